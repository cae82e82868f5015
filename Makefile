# make demo   sees it work          make test   checks what a change must pass
# Both start from a bare clone: Python 3.11 or newer with its venv module is all they ask for.

PYTHON ?= python3
export OPENBLAS_NUM_THREADS ?= 1
JOBS   ?= 2
# Tests start Python hundreds of times: what was compiled is kept, whatever the environment says (make clean removes it).
export PYTHONDONTWRITEBYTECODE :=
BIN    := .venv/bin

# Where the home folder cannot be written, caches go into .venv; installed packages and settings are left alone.
HOME_WRITABLE := $(shell probe=$$(mktemp "$${HOME:-/nowhere}/.vcmm-XXXXXX" 2>/dev/null) && rm -f "$$probe" && echo yes)
ifneq ($(HOME_WRITABLE),yes)
CACHE := $(CURDIR)/.venv/cache
export PIP_NO_CACHE_DIR := 1
export XDG_CACHE_HOME := $(CACHE)
export XDG_DATA_HOME := $(CACHE)/data
export NUMBA_CACHE_DIR := $(CACHE)/numba
export MPLCONFIGDIR := $(CACHE)/matplotlib
export PYVISTA_USERDATA_PATH := $(CACHE)/pyvista
export IPYTHONDIR := $(CACHE)/ipython
export JUPYTER_CONFIG_DIR := $(CACHE)/jupyter/config
export JUPYTER_DATA_DIR := $(CACHE)/jupyter/data
export JUPYTER_RUNTIME_DIR := $(CACHE)/jupyter/runtime
endif

.PHONY: help demo test test-all count lint types docs bench exam audit referee clean
.DEFAULT_GOAL := help

help: ## this list
	@grep -E '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 10

demo: .venv/.installed ## install, then measure, evaluate and write a report
	$(BIN)/vcmm demo

test: lint types ## install, then lint, types, tests, examples of the documentation, notebooks
	$(BIN)/python -m pytest -n $(JOBS) --dist loadscope

test-all: .venv/.installed-all ## install, then pages and workbench in a browser, documentation, wheel, STEP, long fuzz, whole jobs
	$(BIN)/python -m pytest -m thorough -n $(JOBS) --dist loadscope

count: .venv/.installed-dev ## counts over many drawn parts, machines and effects: an hour and more
	$(BIN)/python -m pytest -m count -n $(JOBS) --dist loadscope

lint: .venv/.installed-dev ## style and formatting
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: .venv/.installed-dev ## type hints
	$(BIN)/mypy

docs: .venv/.installed-dev ## documentation as web pages in docs/_build/html
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs docs/_build/html
	@echo "open docs/_build/html/index.html"

gallery: .venv/.installed-dev ## docs/gallery.md and its pictures, each out of the report that its command writes
	$(BIN)/python docs/make_gallery.py

bench: .venv/.installed-dev ## run times, each beside the plain way of doing it; then the exam
	@set -e; for file in benchmarks/bench_*.py; do echo "$$file"; $(BIN)/python "$$file"; done
	@$(MAKE) exam

exam: .venv/.installed-dev ## ten minutes of concealed effects put to diagnose, with plain methods beside it; each effect deleted
	$(BIN)/python -m tests.house.small_jobs
	$(BIN)/python tools/calibrate_statistics.py 8 laser
	$(BIN)/python tools/calibrate_statistics.py 8 tracer
	$(BIN)/python tools/calibrate_statistics.py 8 table
	$(BIN)/python tools/calibrate_statistics.py 8 head
	$(BIN)/python tools/calibrate_statistics.py 10 design
	$(BIN)/python -m benchmarks.exam --plan ten-minutes --jobs $(JOBS) --budget 10min --out exam.jsonl

audit: .venv/.installed-dev ## count coverage of the published tasks and write docs/audit.md; goes on where it stopped
	$(BIN)/python tools/audit_table.py

referee: .venv/.installed-dev ## a judge that shares nothing counts what is claimed, 400 parts a cell (many hours); goes on where it stopped
	$(BIN)/python -m referee --parts 400 --seed 1 --jobs $(JOBS) --out referee.jsonl
	$(BIN)/python -m referee --table referee.jsonl

clean: ## remove .venv, caches and everything that was made
	rm -rf .venv .pytest_cache .mypy_cache .ruff_cache .hypothesis .benchmarks build dist docs/_build docs/effects.md docs/reference.md docs/lesson vcmm-demo
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

.venv/.installed: pyproject.toml constraints.txt
	@sh tools/venv.sh $@ "" "$(PYTHON)"

.venv/.installed-dev: pyproject.toml constraints.txt
	@sh tools/venv.sh $@ "[dev]" "$(PYTHON)"

.venv/.installed-all: .venv/.installed-dev
	@sh tools/venv.sh $@ "[all]" "$(PYTHON)"
