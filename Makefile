# The commands of the project; `make run` and `make test` do all the set-up they need.
PYTHON ?= python3
VENV := .venv
ifeq ($(OS),Windows_NT)
BIN := $(VENV)/Scripts
else
BIN := $(VENV)/bin
endif
STAMP := $(VENV)/.installed
# One thread per numerical library: the tests run side by side already.
THREADS := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1

.PHONY: run test lint fast browser bench trust clean help

help:  ## List the commands
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*##/\t/'

run: $(STAMP)  ## Install and open the demonstration take in the application
	$(BIN)/markermend demo

test: $(STAMP) lint fast browser  ## Install and run everything: lint, fast tests, wheel, browser, real data

$(STAMP): pyproject.toml constraints.txt
	$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or newer is needed; set PYTHON=...") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[dev]'
	$(BIN)/python -c 'import pathlib; pathlib.Path("$(STAMP)").touch()'

lint: $(STAMP)  ## Style, types, import contracts, spelling
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/codespell core app tests assets/docs README.md CHANGELOG.md CONTRIBUTING.md

fast: $(STAMP)  ## Everything that needs no browser
	$(THREADS) $(BIN)/python -m pytest -n 2 tests/core tests/app

browser: $(STAMP)  ## The page in a real browser; gets a Chromium if none is there
	$(BIN)/python tests/browser/get_chromium.py
	$(THREADS) $(BIN)/python -m pytest tests/browser

bench: $(STAMP)  ## Speed and memory, as ratios
	$(THREADS) $(BIN)/python -m tests.bench.desk --json bench-desk.json

trust: $(STAMP)  ## Hardening with figures: hostile files, exports, reviews, numerics (80 minutes)
	$(THREADS) $(BIN)/python -m tests.trust

clean:  ## Remove what the commands above made
	rm -rf $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis dist
