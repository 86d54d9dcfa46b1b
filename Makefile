# Chores of a developer; each works from a fresh clone. 'make check' is what .ci/run does after the tests.
VENV ?= .venv
BIN := $(VENV)/bin

COVERAGE := build/coverage

.PHONY: install test coverage docs correction lint shape types imports wheel check clean

install:
	python3 -m venv $(VENV)
	$(BIN)/pip install --quiet -c constraints.txt -e '.[test]'

test:
	$(BIN)/pytest

# Lines of beadband and analysis that the tests run, in whatever process; fails below 95 %.
coverage:
	mkdir -p $(COVERAGE)
	COVERAGE_FILE=$(abspath $(COVERAGE))/data $(BIN)/coverage run -m pytest
	COVERAGE_FILE=$(abspath $(COVERAGE))/data $(BIN)/coverage combine --quiet
	COVERAGE_FILE=$(abspath $(COVERAGE))/data $(BIN)/coverage report

# The pages of reference: parameters.md, results.md, results.schema.json. A test says when they are out of date.
docs:
	$(BIN)/python -m beadband.reporting.documents docs

# The map of what bending makes of the string limit: thousands of releases, some minutes on two cores.
correction:
	$(BIN)/python -m beadband.studies.correction --out build/correction
	cp build/correction/correction.json beadband/model/correction.json

lint:
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

# The type checker and the contracts of imports read packages where they are installed: they are given that shape.
shape:
	rm -rf build/shape && mkdir -p build/shape
	cp -r beadband build/shape/ && cp -r analysis lmp_inputs build/shape/beadband/

types: shape
	cd build/shape && ../../$(BIN)/mypy --config-file ../../pyproject.toml -p beadband

imports: shape
	cd build/shape && PYTHONPATH=. ../../$(BIN)/lint-imports --config ../../pyproject.toml --no-cache

# What is installed holds the scripts, and no top-level package but beadband.
wheel:
	rm -rf build/wheel && $(BIN)/pip wheel --quiet --no-deps -w build/wheel .
	$(BIN)/python -m zipfile -l build/wheel/beadband-*.whl | grep -q 'beadband/lmp_inputs/release.in'
	$(BIN)/python -m zipfile -l build/wheel/beadband-*.whl | grep -q 'beadband/reporting/page.js'
	! $(BIN)/python -m zipfile -l build/wheel/beadband-*.whl | grep -E '^(analysis|lmp_inputs|tests)/'

check: lint types imports wheel

clean:
	rm -rf build *.egg-info $(VENV) .mypy_cache .ruff_cache .pytest_cache
