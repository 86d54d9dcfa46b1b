# Chores of a developer; each works from a fresh clone. 'make check' is what .ci/run does after the tests.
VENV ?= .venv
BIN := $(VENV)/bin

COVERAGE := build/coverage

.PHONY: install test coverage docs site correction lint shape types imports dist check clean

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

# The pages of reference, made of the tables and of the parser. A test says when they are out of date.
docs:
	$(BIN)/python -m beadband.reporting.documents docs
	$(BIN)/python -c "from beadband.cli import reference; print(reference(), end='')" > docs/commands.md

# The documents as a site in build/site; a dead link, or a page that nothing leads to, is an error.
site: shape
	$(BIN)/pip install --quiet -c constraints.txt -e '.[docs]'
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

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

# Source and wheel, built and installed as a user would, in another folder; the wheel holds no top-level package but
# beadband. Every Python that is named is tried: make dist PYTHONS="python3.11 python3.13".
PYTHONS ?= python3
dist:
	rm -rf build/dist build/installed && $(BIN)/pip install --quiet -c constraints.txt build
	$(BIN)/python -m build --outdir build/dist . >build/dist.log || (cat build/dist.log; false)
	! $(BIN)/python -m zipfile -l build/dist/beadband-*.whl | grep -E '^(analysis|lmp_inputs|tests)/'
	for python in $(PYTHONS); do for file in build/dist/beadband-*; do \
	    sh .ci/installed $$python $$file || exit 1; done; done

check: lint types imports dist site

clean:
	rm -rf build *.egg-info $(VENV) .mypy_cache .ruff_cache .pytest_cache
