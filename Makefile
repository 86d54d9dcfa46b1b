# Chores of a developer; each works from a fresh clone. 'make check' is what .ci/run does after the tests.
VENV ?= .venv
BIN := $(VENV)/bin

.PHONY: install test lint types wheel check clean

install:
	python3 -m venv $(VENV)
	$(BIN)/pip install --quiet -c constraints.txt -e '.[test]'

test:
	$(BIN)/pytest

lint:
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

# The type checker reads packages where they are installed, so it is given them in that shape.
types:
	rm -rf build/types && mkdir -p build/types
	cp -r beadband build/types/ && cp -r analysis lmp_inputs build/types/beadband/
	cd build/types && ../../$(BIN)/mypy --config-file ../../pyproject.toml -p beadband

# What is installed holds the scripts, and no top-level package but beadband.
wheel:
	rm -rf build/wheel && $(BIN)/pip wheel --quiet --no-deps -w build/wheel .
	$(BIN)/python -m zipfile -l build/wheel/beadband-*.whl | grep -q 'beadband/lmp_inputs/release.in'
	$(BIN)/python -m zipfile -l build/wheel/beadband-*.whl | grep -q 'beadband/reporting/page.js'
	! $(BIN)/python -m zipfile -l build/wheel/beadband-*.whl | grep -E '^(analysis|lmp_inputs|tests)/'

check: lint types wheel

clean:
	rm -rf build *.egg-info $(VENV) .mypy_cache .ruff_cache .pytest_cache
