# Everything is made inside .venv/ and out/; nothing else on the machine is touched. PYTHON names the interpreter of a new .venv/.
PYTHON ?= python3
BIN := .venv/bin
DEMO := out/fracturing-truck
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check

# Two installations into one environment must not run side by side under make -j.
.NOTPARALLEL:
.PHONY: help demo test test-slow proof bench clean

help:  ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-10s %s\n", $$1, $$2 }' Makefile
	@echo 'Another interpreter: make demo PYTHON=python3.12 (after make clean if .venv/ exists)'

demo: .venv/.installed  ## the fracturing truck, from elements to figures, into out/fracturing-truck
	$(BIN)/modelgen run fracturing-truck --out $(DEMO) --replace

test: .venv/.installed-test  ## lint, types, and every test that is not slow
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/python -m pytest -n 2

test-slow: .venv/.installed-test  ## the slow tests alone
	$(BIN)/python -m pytest -n 2 -m slow

proof: .venv/.installed-test  ## the large counts, listed in tests/proofs.md (hours)
	$(BIN)/python -m pytest -n 2 -m proof

bench: .venv/.installed-bench  ## error against cost beside the peers, into out/bench (20 minutes on two idle cores)
	$(BIN)/python tests/bench/against_peers.py

clean:  ## remove the environment, the caches and what the demo wrote
	rm -rf .venv $(DEMO) .mypy_cache .pytest_cache .ruff_cache build dist
	find modelgen tests -name __pycache__ -type d -prune -exec rm -rf {} +

# The stamps say what stands in .venv/; a newer pyproject.toml installs again.
.venv/.made:
	@$(PYTHON) -c '' 2>/dev/null || { echo "modelgen: '$(PYTHON)' does not run; name a Python of 3.11 or newer, as in: make demo PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "modelgen: '$(PYTHON)' is older than Python 3.11; name a newer one, as in: make demo PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { echo "modelgen: '$(PYTHON)' has no venv; install it (on Debian and Ubuntu the package python3-venv)" >&2; exit 1; }
	$(PYTHON) -m venv .venv
	@touch $@

.venv/.installed: .venv/.made pyproject.toml
	$(INSTALL) -e .
	@touch $@

.venv/.installed-bench: .venv/.made pyproject.toml
	$(INSTALL) -e '.[bench]'
	@touch $@ .venv/.installed

.venv/.installed-test: .venv/.made pyproject.toml
	$(INSTALL) -e '.[test]'
	@touch $@ .venv/.installed
