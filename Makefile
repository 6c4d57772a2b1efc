# `make` lists the targets. Everything runs in .venv, which the first target that needs it sets up.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# By files, since the tests of one share what is slow to make; where a single file is most of the work, test by test.
WORKERS := --numprocesses 2 --dist loadfile --no-loadscope-reorder
SPREAD := --numprocesses 2 --dist worksteal
USUAL := not nightly and not extras and not hostile and not torch and not rclpy
MEASURED := not nightly and not large and not hostile and not torch and not rclpy
RULES := tests/golden tests/oracle tests/properties tests/rulebook tests/unit
# The docs first: one of their tests is the longest.
QUICK := tests/docs $(RULES) tests/agents tests/conformance tests/contract tests/vector
# Formats, lints and type-checks the JavaScript. What it keeps lies in the environment, and it asks nobody for its own updates.
DENO := DENO_DIR=$(VENV)/deno DENO_NO_UPDATE_CHECK=1 $(BIN)/deno
# uv reads no pip.conf: a package index that is set there, such as a mirror, is passed on.
UV = index=$$($(BIN)/python -m pip config get global.index-url 2>/dev/null || echo "$$PIP_INDEX_URL"); \
	$${index:+env UV_DEFAULT_INDEX="$$index"} $(BIN)/uv pip install --python $(BIN)/python
# pip for what torch belongs to: only pip knows where a machine has a build of it without CUDA.
PIP := $(BIN)/python -m pip install --disable-pip-version-check --quiet

# Bytecode is kept, whatever the environment says: every process would compile all sources anew, some five seconds each.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help card compat demo test quick extras train hostile nightly long laws interpreted numba boundscheck coverage mutate browser ros window check format bench pictures golden docs site \
	clean setup pythons

help: ## list the targets
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## /\1\t/' | expand -t 12

compat: $(VENV)/ready ## train with each library that others use, in an environment of its own (gigabytes; docs/reference/compatibility.md)
	$(BIN)/python scripts/compat --page $(CLIENTS)

demo: $(VENV)/ready ## a tournament of seven agents: the report, a video of the final, and the best moments (out/demo)
	$(BIN)/python scripts/demo.py --out out/demo

test: $(VENV)/ready-dev ## run the tests, but for those of nightly and extras
	$(BIN)/pytest $(WORKERS) -m '$(USUAL)' tests

quick: $(VENV)/ready-dev ## before each commit: the tests of the rules, the interfaces, conformance and the docs
	$(BIN)/pytest $(WORKERS) -m '$(USUAL)' $(QUICK)

extras: $(VENV)/ready-extras ## the tests that need large packages: Ray, moviepy
	$(BIN)/pytest -m extras tests

train: $(VENV)/ready-torch ## the scripts that train, for a minute (torch: gigabytes)
	$(BIN)/pytest $(SPREAD) -m torch tests

hostile: $(VENV)/ready-dev ## agents that attack the tournament, its results and each other
	$(BIN)/pytest $(WORKERS) -m 'hostile and not nightly' tests

nightly: long laws interpreted boundscheck coverage mutate compat pythons ## what takes long: the targets that follow, compat, pythons, and ros on each Python
	$(BIN)/python scripts/ros_nodes.py --all

long: $(VENV)/ready-dev ## the tests that make test leaves out
	$(BIN)/pytest $(WORKERS) -m nightly tests

laws: $(VENV)/ready-dev ## the property tests at length, with a million steps of engine against oracle
	CATCH_ARENA_LONG=1 $(BIN)/pytest $(SPREAD) tests/properties tests/replay/test_format.py

# Without the compiler one block of arenas runs every line that a hundred blocks run, a hundred times as fast: what plays that
# many is marked `large`, and left out here and from coverage.
interpreted: $(VENV)/ready-dev ## the tests of the rules without the compiler
	NUMBA_DISABLE_JIT=1 $(BIN)/pytest $(SPREAD) -m 'not large' $(RULES)

numba: $(VENV)/ready-dev ## the tests of the rules, compiled in Numba's own way
	CATCH_ARENA_COMPILER=numba $(BIN)/pytest $(SPREAD) tests/rulebook

boundscheck: $(VENV)/ready-dev ## the tests of the rules, of batches and of compiled opponents, with every index tested
	NUMBA_BOUNDSCHECK=1 $(BIN)/pytest $(SPREAD) $(RULES) tests/vector tests/training/test_opponents.py

# Without the compiler, since compiled code cannot be measured; but first with it, and with an empty cache, for what only the
# compiler calls.
coverage: $(VENV)/ready-extras ## measure coverage: at least 95 % of all, and every line and branch of the rules
	rm -rf out/coverage
	NUMBA_CACHE_DIR=out/coverage/compiled $(BIN)/coverage run -m pytest tests/unit
	NUMBA_DISABLE_JIT=1 $(BIN)/coverage run -m pytest $(WORKERS) -m '$(MEASURED)' tests
	$(BIN)/coverage combine --quiet || true  # a process that a test killed leaves a file that cannot be read
	$(BIN)/coverage report --fail-under 95
	$(BIN)/coverage report --fail-under 100 --include 'catch_arena/core/*'

mutate: $(VENV)/ready-dev ## change the rules, and see that a test notices
	$(BIN)/python scripts/mutate.py

browser: $(VENV)/ready-browser ## play videos and open pages in a headless Chromium
	$(BIN)/pytest tests/browser

window: $(VENV)/ready-window ## play in a real window, on an X server without a screen
	$(BIN)/pytest tests/window

ros: $(VENV)/ready-dev ## real ROS 2 nodes play, and are graded (the environment: 500 MB in .venv-ros, and a compiler)
	$(BIN)/python scripts/ros_nodes.py

pythons: $(VENV)/ready-dev ## the rules, a match, a video and a tournament on each CPython found, with the newest and the oldest dependencies
	$(BIN)/python scripts/pythons.py

check: $(VENV)/ready-dev ## format, lint, types, import contract; of the JavaScript too
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/basedpyright --pythonpath $(BIN)/python
	$(BIN)/lint-imports --no-cache
	$(DENO) fmt --check
	$(DENO) lint
	$(DENO) check

format: $(VENV)/ready-dev ## put the sources into form
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .
	$(DENO) fmt
	$(DENO) lint --fix

bench: $(VENV)/ready-bench ## measure the speed, side by side with others' (docs/explanation/performance.md)
	$(BIN)/python scripts/bench $(if $(PUFFERLIB),--pufferlib '$(PUFFERLIB)') --json out/bench.json --page docs/explanation/performance.md

card: $(VENV)/ready ## measure all shipped agents in the suite, and write docs/reference/card.md; goes on where it was (out/card)
	$(BIN)/python scripts/card.py

pictures: $(VENV)/ready ## draw the README's picture and its animation
	$(BIN)/python scripts/pictures.py

golden: $(VENV)/ready-dev ## make anew what tests compare with: frames, golden matches, the census's counts
	PYTHONPATH=tests $(BIN)/python tests/render/golden.py
	PYTHONPATH=tests $(BIN)/python tests/golden/matches.py
	PYTHONPATH=tests $(BIN)/python tests/rulebook/census/enumeration.py

site: $(VENV)/ready-site ## build the documentation as a site (out/site/index.html)
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs out/site

docs: $(VENV)/ready ## write the tables in docs/ that are made from code
	$(BIN)/python scripts/write_docs.py

setup: $(VENV)/ready-dev ## make .venv with everything that development needs

clean: ## remove .venv, caches and out/
	rm -rf $(VENV) .venv-ros out build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache

$(BIN)/uv:
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 10) <= sys.version_info < (3, 14))' || \
		{ echo "Catch Arena needs Python 3.10 to 3.13; name one: make PYTHON=python3.11 $(MAKECMDGOALS)"; exit 1; }
	@test -x $(BIN)/python || echo "making $(VENV)"
	@test -x $(BIN)/python || { $(PYTHON) -m venv --clear $(VENV) \
		|| { $(PYTHON) -m venv --clear --without-pip $(VENV) && $(PYTHON) -m pip --python $(BIN)/python install pip; }; \
		} > $(VENV).log 2>&1 && rm -f $(VENV).log || { rm -rf $(VENV); echo "$(PYTHON) cannot make a virtual environment: see $(VENV).log;" \
		"on Debian and Ubuntu: apt-get install python3-venv"; exit 1; }
	@$(PIP) --upgrade pip uv

$(VENV)/ready: pyproject.toml $(BIN)/uv
	@$(UV) --editable '.[video]'
	@touch $@

$(VENV)/ready-dev: $(VENV)/ready
	@$(UV) --group test --group check
	@touch $@

$(VENV)/ready-extras: $(VENV)/ready-dev
	@$(UV) --group extras
	@touch $@

$(VENV)/ready-torch: $(VENV)/ready-dev
	@echo "installing torch (3 GB)"
	@$(PIP) --group torch
	@touch $@

$(VENV)/ready-bench: $(VENV)/ready
	@echo "installing the peers (gigabytes)"
	@$(PIP) --editable '.[bench]' || echo "not all peers could be installed: the run names those that are missing"
	@touch $@

$(VENV)/ready-site: $(VENV)/ready
	@$(UV) --group site
	@touch $@

$(VENV)/ready-browser: $(VENV)/ready-dev
	@command -v chromium >/dev/null || { test "$$(id -u)" = 0 && apt-get update -qq && apt-get install -y -qq chromium; } \
		|| { echo "the browser tests need Chromium: apt-get install chromium"; exit 1; }
	@$(UV) --group browser
	@touch $@

$(VENV)/ready-window: $(VENV)/ready-dev
	@command -v Xvfb >/dev/null && command -v xdotool >/dev/null && command -v xwd >/dev/null \
		|| { test "$$(id -u)" = 0 && apt-get update -qq && apt-get install -y -qq xvfb xdotool x11-apps; } \
		|| { echo "the window's tests need Xvfb, xdotool and xwd: apt-get install xvfb xdotool x11-apps"; exit 1; }
	@touch $@
