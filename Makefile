# `make` lists the targets. Everything runs in .venv, which the first target that needs it sets up.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --disable-pip-version-check --quiet
# uv installs several times as fast as pip. It reads no pip.conf, so a package index that is set there is passed on.
UV = index=$$($(BIN)/python -m pip config get global.index-url 2>/dev/null || echo "$$PIP_INDEX_URL"); \
	$${index:+env UV_DEFAULT_INDEX="$$index"} $(BIN)/uv pip install --python $(BIN)/python
DENO := DENO_DIR=$(VENV)/deno DENO_NO_UPDATE_CHECK=1 $(BIN)/deno
# Tests of one file share fixtures that are slow to make. SPREAD is for targets in which a single file is most of the work.
WORKERS := --numprocesses 2 --dist loadfile --no-loadscope-reorder
SPREAD := --numprocesses 2 --dist worksteal
USUAL := not nightly and not extras and not hostile and not torch and not rclpy
MEASURED := not nightly and not hostile and not torch and not rclpy
RULES := tests/golden tests/oracle tests/properties tests/rulebook tests/unit
QUICK := $(RULES) tests/contract tests/docs/test_docs.py tests/docs/test_docstrings.py

# Keep bytecode: without it every process takes some five seconds to compile all sources.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help card compat demo test quick extras train hostile nightly long laws interpreted numba boundscheck coverage \
	mutate browser ros window check format bench pictures golden docs site clean setup ends pythons

help: ## list the targets
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## /\1\t/' | expand -t 12

compat: $(VENV)/ready ## train with each supported library, in an environment of its own (gigabytes; docs/reference/compatibility.md)
	$(BIN)/python scripts/compat.py $(CLIENTS)

demo: $(VENV)/ready ## play a tournament of six agents; make its report, a video of the final, and the best moments (out/demo)
	rm -rf out/demo
	$(BIN)/python scripts/demo.py --out out/demo

# A third of the time is waiting for processes and clocks, so that two cores have room for four processes.
test: $(VENV)/ready-dev ## run the usual tests
	$(BIN)/pytest $(WORKERS) --numprocesses 4 -m '$(USUAL)' tests

quick: $(VENV)/ready-dev ## run the tests of the rules and the interfaces in a minute, before each commit
	$(BIN)/pytest $(WORKERS) -m '$(USUAL)' $(QUICK)

extras: $(VENV)/ready-dev $(VENV)/ready-extras ## run the tests that need large packages: Ray, moviepy
	$(BIN)/pytest -m extras tests

train: $(VENV)/ready-dev $(VENV)/ready-torch ## run short trainings (torch: 3 GB)
	$(BIN)/pytest $(SPREAD) -m 'torch and not nightly' tests

hostile: $(VENV)/ready-dev ## run agents that attack the tournament, its results and each other
	$(BIN)/pytest $(WORKERS) -m 'hostile and not nightly' tests

nightly: long laws boundscheck numba coverage mutate compat pythons ## run all tests that take long, among them compat, pythons, and ros on each Python
	$(BIN)/python scripts/ros_nodes.py --all

long: $(VENV)/ready-dev $(VENV)/ready-torch ## run the tests that are marked nightly (torch: 3 GB)
	$(BIN)/pytest $(WORKERS) -m nightly tests

laws: $(VENV)/ready-dev ## run the property tests at length, with a million steps of engine against oracle
	CATCH_ARENA_LONG=1 $(BIN)/pytest $(SPREAD) tests/properties tests/replay/test_format.py

# Tests of many blocks of arenas are marked `large`. Without the compiler they take too long, and one block has all code.
interpreted: $(VENV)/ready-dev ## run the tests of the rules without the compiler, as coverage does too
	NUMBA_DISABLE_JIT=1 $(BIN)/pytest $(SPREAD) -m 'not large' $(RULES)

numba: $(VENV)/ready-dev ## run the tests of the rules, compiled in Numba's own way
	CATCH_ARENA_COMPILER=numba $(BIN)/pytest $(SPREAD) tests/rulebook

boundscheck: $(VENV)/ready-dev ## run the tests of the rules, of batches and of compiled opponents, with bounds checks
	NUMBA_BOUNDSCHECK=1 $(BIN)/pytest $(SPREAD) $(RULES) tests/vector tests/training/test_opponents.py

# Coverage cannot measure compiled code: all tests run with it, and those of the rules once more without the compiler. The
# cache is empty at first, for the functions that only the compiler calls.
coverage: $(VENV)/ready-dev $(VENV)/ready-extras ## measure coverage: at least 95 %, and every line and branch of the rules
	rm -rf out/coverage
	NUMBA_CACHE_DIR=$(CURDIR)/out/coverage/compiled $(BIN)/coverage run -m pytest $(WORKERS) -m '$(MEASURED)' tests
	NUMBA_DISABLE_JIT=1 $(BIN)/coverage run -m pytest $(SPREAD) -m 'not nightly and not large' $(RULES) tests/vector
	$(BIN)/coverage combine --quiet || true  # a killed process leaves a damaged file
	$(BIN)/coverage report --fail-under 95
	$(BIN)/coverage report --fail-under 100 --include 'catch_arena/core/*'

mutate: $(VENV)/ready-dev ## change the rules in 4,000 ways, and check that a test notices each
	$(BIN)/python scripts/mutate.py

browser: $(VENV)/ready-dev $(VENV)/ready-browser ## play videos and open pages in Chromium, which must be installed
	@command -v chromium >/dev/null || { echo "Chromium is not installed: apt-get install chromium"; exit 1; }
	$(BIN)/pytest tests/browser

window: $(VENV)/ready-dev ## play in a real window, on an X server without a screen, which must be installed
	@(for one in Xvfb xdotool; do command -v $$one >/dev/null || exit 1; done) || { echo "X11 programs are missing: apt-get install xvfb xdotool"; exit 1; }
	$(BIN)/pytest tests/window

ros: $(VENV)/ready-dev ## play and grade with real ROS 2 nodes (needs a compiler, and 700 MB in .venv-ros)
	$(BIN)/python scripts/ros_nodes.py $(ROS)

ends: $(VENV)/ready-dev ## play golden matches on the lowest CPython with the oldest dependencies, and on the highest with the newest
	$(BIN)/python scripts/pythons.py --ends

pythons: $(VENV)/ready-dev ## try each installed CPython, with the newest and the oldest dependencies
	$(BIN)/python scripts/pythons.py

check: $(VENV)/ready-dev ## check format, lint, types and imports
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/basedpyright --pythonpath $(BIN)/python
	$(BIN)/lint-imports --no-cache
	$(DENO) fmt --check
	$(DENO) lint
	$(DENO) check

format: $(VENV)/ready-dev ## format the sources, and fix what the linters can fix
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .
	$(DENO) fmt
	$(DENO) lint --fix

bench: $(VENV)/ready-bench ## measure the speed, next to other environments (docs/explanation/performance.md)
	$(BIN)/python scripts/bench $(if $(PUFFERLIB),--pufferlib '$(PUFFERLIB)') --json out/bench.json --page docs/explanation/performance.md

card: $(VENV)/ready ## measure all shipped agents in the suite, and write docs/reference/card.md; keeps its matches in out/card
	$(BIN)/python scripts/card.py
	$(BIN)/python scripts/cross_play.py

pictures: $(VENV)/ready ## draw the README's picture and animation
	$(BIN)/python scripts/pictures.py

golden: $(VENV)/ready-dev ## write again the frames, golden matches and counts that tests compare with
	PYTHONPATH=tests $(BIN)/python tests/render/golden.py
	PYTHONPATH=tests $(BIN)/python tests/golden/matches.py
	PYTHONPATH=tests $(BIN)/python tests/rulebook/census/enumeration.py

site: $(VENV)/ready-site ## build the documentation as a site (out/site/index.html)
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs out/site

docs: $(VENV)/ready ## write the tables in docs/ that come from code
	$(BIN)/python scripts/write_docs.py

setup: $(VENV)/ready-dev ## make .venv with the tools for development

clean: ## remove .venv, caches and out/
	rm -rf $(VENV) .venv-ros out build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache

$(BIN)/uv:
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 10) <= sys.version_info < (3, 14))' || \
		{ echo "Catch Arena needs Python 3.10 to 3.13; name one: make PYTHON=python3.11 $(MAKECMDGOALS)"; exit 1; }
	@$(PYTHON) -m venv $(VENV) > /dev/null || \
		{ rm -rf $(VENV); echo "cannot make $(VENV); on Debian and Ubuntu: apt-get install python3-venv"; exit 1; }
	@$(PIP) uv

$(VENV)/ready: pyproject.toml | $(BIN)/uv
	@$(UV) --editable '.[video]'
	@touch $@

$(VENV)/ready-bench: $(VENV)/ready
	@$(PIP) --upgrade pip
	@$(PIP) --editable '.[bench]' || echo "not all peers could be installed; the run names those that are missing"
	@touch $@

# Only pip finds a build of torch without CUDA on a machine that has one.
$(VENV)/ready-torch: $(VENV)/ready
	@echo "installing torch (3 GB)"
	@$(PIP) --upgrade pip
	@$(PIP) --group torch
	@touch $@

# Each other group of pyproject.toml: dev, extras, browser, site.
$(VENV)/ready-%: $(VENV)/ready
	@$(UV) --group $*
	@touch $@
