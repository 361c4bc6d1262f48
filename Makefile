# The verbs of this project; CONTRIBUTING.md says when to use which.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP_INSTALL = $(BIN)/python -m pip install --quiet --constraint constraints.txt
task ?= nav_complex
ARGS ?=
AT_ONCE = -n auto --maxprocesses 4  # tests at once: more workers would wait for each other's physics

.PHONY: help install dev train evaluate check test test-fast test-long test-node test-versions faults bench results ablation docs clean

help:
	@echo 'make train task=nav_complex ARGS="seed=1 total_steps=5000"   set up, train, evaluate'
	@echo 'make test       set up and run the tests        make test-fast  without the slow ones'
	@echo 'make check      format, lint, types, models, documents     make bench      speed of environment and training'
	@echo 'make results    the runs behind the README      make ablation   what each factor of the learning does'
	@echo 'make test-node  recordings, read by the libraries that Foxglove reads with (Node)'
	@echo 'make test-versions  with the lowest versions of the libraries, and with Python 3.12'
	@echo 'make faults     runs that are killed, damaged and compared to the last bit'
	@echo 'make docs       the documentation as a site, build/docs/index.html'
	@echo 'make clean      remove .venv and caches         ARGS=list with the two: what they would train'

# Installing writes the stamp last: an interrupted install is begun again.
$(VENV)/made:
	$(PYTHON) -c 'import sys; sys.exit(0 if (3, 11) <= sys.version_info[:2] < (3, 13) else "asddpg needs Python 3.11 or 3.12: make PYTHON=python3.12")'
	$(PYTHON) -m venv $(VENV)
	@touch $@

$(VENV)/installed: $(VENV)/made pyproject.toml constraints.txt
	$(PIP_INSTALL) --editable .
	@touch $@

$(VENV)/dev: $(VENV)/installed
	$(PIP_INSTALL) --editable '.[dev]'
	@touch $@

$(VENV)/docs: $(VENV)/installed
	$(PIP_INSTALL) --editable '.[docs]'
	@touch $@

$(VENV)/bench: $(VENV)/installed
	$(PIP_INSTALL) --editable '.[bench]'
	@touch $@

install: $(VENV)/installed
dev: $(VENV)/dev

train: install
	$(BIN)/python -m asddpg.train task=$(task) $(ARGS)

evaluate: install
	$(BIN)/python -m asddpg.evaluate $(ARGS)

check: dev docs
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/python -m tools.check_models

# Warnings are errors: a link, a heading or a docstring that leads nowhere stops the build.
docs: $(VENV)/docs
	$(BIN)/python -m sphinx --quiet --fail-on-warning --keep-going docs build/docs

test: dev
	$(BIN)/python -m pytest $(AT_ONCE)

test-fast: dev
	$(BIN)/python -m pytest $(AT_ONCE) -m "not slow and not long and not faults"

test-long: dev $(VENV)/bench
	$(BIN)/python -m pytest -m long

faults: dev
	$(BIN)/python -m pytest -m faults -s tests/faults $(ARGS)

test-versions: dev
	.ci/versions $(BIN)/python

test-node: dev
	tests/node/check $(BIN)/python

bench: $(VENV)/bench
	$(BIN)/python -m tools.bench $(ARGS)

results: install
	$(BIN)/python -m tools.results $(ARGS)

ablation: install
	$(BIN)/python -m tools.ablation $(ARGS)

clean:
	rm -rf $(VENV) .hypothesis .pytest_cache .mypy_cache .ruff_cache build dist *.egg-info
