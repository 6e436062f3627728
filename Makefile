# Everything a user or a developer runs. Needs Python >= 3.11, pip and make; all else goes into .venv.
# pip is configured, as everywhere, by its own environment variables and files.

SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c
.DELETE_ON_ERROR:
ifndef LANES
.NOTPARALLEL:
endif
.DEFAULT_GOAL := help

# Each program that a test starts would else compile every module that it imports: pip leaves that to Python (below).
unexport PYTHONDONTWRITEBYTECODE

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
JOBS   ?= 2
BASE   := $(VENV)/.installed
DEV    := $(VENV)/.installed-dev
STUDY  := $(VENV)/.installed-study
PIP    := $(BIN)/python -m pip install --quiet --no-compile  # Python compiles what is imported
FLOOR  := .venv-floor
FLOOR_TESTS := tests/cli/test_commands.py tests/cli/test_fit_decide.py tests/cli/test_pressure.py tests/cli/test_hostile.py \
  tests/unit/test_doors.py tests/unit/test_finger.py tests/unit/test_io_tables.py tests/unit/test_io_units.py \
  tests/unit/test_io_finger_file.py tests/unit/test_lanes.py tests/unit/test_layered.py tests/unit/test_locate.py tests/unit/test_press.py \
  tests/unit/test_pressure_area_solver.py

.PHONY: help demo test browser firefox test-floor lint types check docs loops bench study figures clean

help: ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-10s %s\n", $$1, $$2 }' Makefile

demo: $(BASE) ## the main job on a simulated recording: segment, calibrate, locate; writes out/demo
	@PATH="$(CURDIR)/$(BIN):$$PATH" bash examples/demo.sh out/demo

# Two lanes, so that both cores have work: what tests need is installed while the loops are compiled; types and docs,
# which keep one core busy at most, run beside the tests.
test: $(BASE) ## everything: lint, types, the docs without warnings, all tests (what .ci/run runs)
	@$(MAKE) --no-print-directory --jobs=2 LANES=2 $(DEV) loops
	@$(MAKE) --no-print-directory --jobs=2 LANES=2 check lint types docs

lint: $(DEV) ## ruff: rules and layout
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

# It makes no garbage to speak of, and a quarter of its time went into the search: `mypy` alone says the same, later.
types: $(DEV) ## mypy, strict, over src
	$(BIN)/python -c 'import gc; gc.enable = gc.disable; from mypy.__main__ import console_entry; console_entry()'

check: $(DEV) ## pytest: unit, verification, validation, command line, doctests, code blocks of the docs
	OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -q -n $(JOBS) --dist worksteal

docs: $(DEV) ## the documentation and its gallery into docs/_build/html; a warning is an error
	OPENBLAS_NUM_THREADS=1 $(BIN)/sphinx-build -W --keep-going -q -j $(JOBS) -b html docs docs/_build/html
	@echo "docs/_build/html/index.html"

loops: $(BASE) # compiled once, and not by each worker of pytest and by the gallery
	@$(BIN)/python tests/loops.py

browser: ## Chromium of Debian or Ubuntu, for the tests of the studio's page, which are skipped without one
	@command -v chromium chromium-browser google-chrome >/dev/null || { \
	  sudo=$$([ "$$(id -u)" = 0 ] || command -v sudo || true); \
	  $$sudo apt-get update -qq && $$sudo apt-get install -y -qq --no-install-recommends chromium fonts-dejavu-core; }

firefox: ## Firefox of Debian, for benchmarks/study_firefox.py, which says so where there is none
	@command -v firefox-esr firefox >/dev/null || { \
	  sudo=$$([ "$$(id -u)" = 0 ] || command -v sudo || true); \
	  $$sudo apt-get update -qq && $$sudo apt-get install -y -qq --no-install-recommends firefox-esr fonts-dejavu-core; }

test-floor: ## the core of the tests at the lowest versions that pyproject.toml allows, in a venv of its own
	@test -x $(FLOOR)/bin/python || "$(PYTHON)" -m venv $(FLOOR)
	@$(FLOOR)/bin/python -c "import tomllib; p = tomllib.load(open('pyproject.toml', 'rb'))['project']; \
	  needs = p['dependencies'] + p['optional-dependencies']['parquet']; \
	  print('\n'.join(need.replace('>=', '==') for need in needs))" > $(FLOOR)/floor.txt
	$(FLOOR)/bin/python -m pip install --quiet --constraint $(FLOOR)/floor.txt --editable ".[parquet]" "pytest>=8.2" "hypothesis>=6.112"
	$(FLOOR)/bin/python -m pytest -q -W default $(FLOOR_TESTS)

bench: $(DEV) ## benchmarks beside their peers: accuracy, speed, import time
	@shopt -s nullglob; for program in benchmarks/bench_*.py; do echo "== $$program"; $(BIN)/python "$$program"; done

study: $(STUDY) ## heavier than a test: long statistics, finite elements, blind calibration, real skins, placement, mutants, Firefox
	OPENBLAS_NUM_THREADS=1 $(BIN)/pytest -q -n $(JOBS) -m long tests
	@shopt -s nullglob; for program in benchmarks/study_*.py; do echo "== $$program"; $(BIN)/python "$$program"; done

figures: $(DEV) ## the memo's figures into out/figures, and the drawings of the README and the docs
	$(BIN)/subskin figures -o out/figures
	$(BIN)/python docs/images/draw.py

clean: ## remove what was built; .venv stays (rm -r .venv removes that)
	rm -rf out docs/_build docs/gallery docs/api/generated docs/sg_execution_times.rst
	rm -rf .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find src tests docs examples -type d -name __pycache__ -prune -exec rm -rf {} +

# A stamp is as old as the last installation: pip runs again when pyproject.toml has changed.
$(BIN)/python:
	@command -v "$(PYTHON)" >/dev/null || { echo "make: no '$(PYTHON)' found. Install Python >= 3.11, or say make PYTHON=/path/to/python" >&2; exit 1; }
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "make: $$($(PYTHON) --version) is too old, Python >= 3.11 is needed: make PYTHON=python3.12" >&2; exit 1; }
	@"$(PYTHON)" -c 'import venv, ensurepip' 2>/dev/null || \
	  { echo "make: '$(PYTHON)' cannot make virtual environments. On Debian and Ubuntu: sudo apt install python3-venv" >&2; exit 1; }
	"$(PYTHON)" -m venv $(VENV)

$(BASE): pyproject.toml | $(BIN)/python
	$(PIP) --editable .
	@touch $@

$(DEV): pyproject.toml | $(BIN)/python
	$(PIP) --editable ".[docs,test]"
	@touch $(BASE) $@

$(STUDY): pyproject.toml $(DEV)
	$(PIP) --editable ".[study]"
	@touch $@
