# `make` lists the targets. Everything runs in .venv, which the first target that needs it sets up.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet --quiet

.DEFAULT_GOAL := help
.PHONY: help demo test fast check format bench pictures docs clean setup

help: ## list the targets
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## /\1\t/' | expand -t 12

demo: $(VENV)/ready ## play a tournament of all shipped agents, and film the final (out/demo)
	$(BIN)/python scripts/demo.py --out out/demo

test: $(VENV)/ready-dev ## run the tests
	$(BIN)/pytest --numprocesses 2 --dist loadgroup tests

fast: $(VENV)/ready-dev ## run the rulebook's tests only
	$(BIN)/pytest tests/rulebook

check: $(VENV)/ready-dev ## format, lint, types, import contract
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache

format: $(VENV)/ready-dev ## put the sources into form
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: $(VENV)/ready-dev ## measure the speed, side by side with a peer
	$(BIN)/python scripts/bench.py

pictures: $(VENV)/ready ## draw the README's picture
	$(BIN)/python scripts/pictures.py

docs: $(VENV)/ready ## write the tables in docs/ that are made from code
	$(BIN)/python scripts/write_docs.py

setup: $(VENV)/ready-dev ## make .venv with everything that development needs

clean: ## remove .venv, caches and out/
	rm -rf $(VENV) out build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache

# A Debian without python3-venv can make an environment only without pip; its own pip then fills it.
$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "Catch Arena needs Python 3.11 or newer; name one with: make PYTHON=python3.11 $(MAKECMDGOALS)"; exit 1; }
	@$(PYTHON) -m venv $(VENV) >/dev/null 2>&1 || { rm -rf $(VENV) \
		&& $(PYTHON) -m venv --without-pip $(VENV) \
		&& $(PYTHON) -m pip --quiet --python $(VENV)/bin/python install pip; }

$(VENV)/ready: pyproject.toml | $(VENV)/bin/python
	@echo "setting up $(VENV) (about a minute)"
	@$(PIP) install --upgrade 'pip>=25.1'
	@$(PIP) install --editable '.[video]'
	@touch $@

$(VENV)/ready-dev: $(VENV)/ready
	@$(PIP) install --group test --group check
	@touch $@
