# make demo   make the environment and draw the first diagram, rub.nc and rub.png
# make test   make the environment and run the tests; they compile quickly and compute slowly (tests/quick.py)
# make test-slow   further cases, of tests that compile much and are marked so
# make test-all   all of them compiled as for users, and the long statistical searches that are marked so
# make coverage   run the tests and print which lines no test runs
# make lint   ruff and pyright
# make bench  measure, and rewrite benchmarks/RESULTS.md
# make figures  the thesis' figures into figures/, with their numbers
# make notebooks   execute the notebooks, and write their pages to docs/notebooks anew
# make docs   build the documentation into docs/_build
# make picture  draw the README's picture anew
#
# PYTHON=... chooses an interpreter and VENV=... a folder; by default the newest Python that runs here.

# A name on the path may be a shim with nothing behind it: each candidate is run before it is believed.
NEWEST := for p in python3.14 python3.13 python3.12 python3.11 python3 python; do \
	$$p -c 'import sys, venv, pip; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))' \
	>/dev/null 2>&1 && { command -v $$p; break; }; done
PYTHON ?= $(shell $(NEWEST))
VENV ?= .venv
BIN := $(VENV)/bin
# A file goes to one worker, which compiles for all its tests; those that take longest begin first (tests/conftest.py).
# Of three workers one waits for processes that a test began, on two cores.
PYTEST = $(BIN)/python -m pytest --numprocesses 3 --dist loadfile --no-loadscope-reorder --durations 10

.PHONY: demo test test-slow test-all coverage lint bench figures docs notebooks picture clean

demo: $(VENV)/.package
	$(BIN)/lobex lobes rub --out rub

test: $(VENV)/.test
	$(PYTEST)

test-slow: $(VENV)/.test
	$(PYTEST) -m slow

test-all: $(VENV)/.test
	XLA_FLAGS= $(PYTEST) -m "slow or search or not search"

coverage: $(VENV)/.test
	$(PYTEST) --cov=lobex

lint: $(VENV)/.dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright --pythonpath $(BIN)/python

bench: $(VENV)/.bench
	$(BIN)/python benchmarks/measure.py
	$(BIN)/python benchmarks/cores.py
	$(BIN)/python benchmarks/general.py
	$(BIN)/python benchmarks/cutters.py
	$(BIN)/python benchmarks/motion.py
	$(BIN)/python benchmarks/cost_growth.py
	$(BIN)/python benchmarks/blades.py
	$(BIN)/python benchmarks/rod_wear.py
	$(BIN)/python benchmarks/bladings.py
	$(BIN)/python benchmarks/growth_of_studies.py
	$(BIN)/python benchmarks/sharing_of_studies.py
	$(BIN)/python benchmarks/programs.py
	$(BIN)/python benchmarks/first_answer.py
	$(BIN)/python benchmarks/latency.py

figures: $(VENV)/.package
	$(BIN)/lobex reproduce --out figures

docs: $(VENV)/.docs
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet docs docs/_build

notebooks: $(VENV)/.notebooks
	OPENBLAS_NUM_THREADS=1 $(BIN)/python notebooks/render.py

picture: $(VENV)/.package
	$(BIN)/lobex lobes rub --out docs/images/rub
	rm docs/images/rub.nc

clean:
	rm -rf $(VENV) docs/_build

# Debian ships venv without ensurepip: then the interpreter's own pip installs into the environment.
# Sources that are installed as they lie are compiled here, since an environment may forbid Python to keep what it makes
# of them, and then every process makes it again.
$(VENV)/.made:
	@test -n "$(PYTHON)" || { echo "lobex needs Python 3.11 or newer, with pip and venv" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV) 2>/dev/null || $(PYTHON) -m venv --clear --without-pip $(VENV)
	$(BIN)/python -m compileall -q src
	touch $@

INSTALL = $(PYTHON) -m pip --python $(BIN)/python install --quiet --disable-pip-version-check --editable

$(VENV)/.package: $(VENV)/.made pyproject.toml
	$(INSTALL) .
	touch $@

$(VENV)/.test: $(VENV)/.made pyproject.toml
	$(INSTALL) '.[test]'
	touch $@ $(VENV)/.package

$(VENV)/.bench: $(VENV)/.made pyproject.toml
	$(INSTALL) '.[bench]'
	touch $@ $(VENV)/.test $(VENV)/.package

$(VENV)/.dev: $(VENV)/.made pyproject.toml
	$(INSTALL) '.[dev]'
	touch $@ $(VENV)/.test $(VENV)/.package

$(VENV)/.notebooks: $(VENV)/.made pyproject.toml
	$(INSTALL) '.[notebooks]'
	touch $@ $(VENV)/.package

$(VENV)/.docs: $(VENV)/.made pyproject.toml
	$(INSTALL) '.[docs]'
	touch $@ $(VENV)/.package
