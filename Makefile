# Set-up and the main jobs. Needs python3 (3.11 or newer) and make; everything else goes into .venv.
PYTHON ?= python3
BIN := .venv/bin
# The service: where it goes, and the interpreter it runs with (no home directory: the unit cannot see those).
DESTDIR ?=
PREFIX ?= /opt/longreach
SERVICE_PYTHON ?= /usr/bin/python3

.PHONY: venv demo test test-slow hil blind lint format bench docs install uninstall clean

venv: .venv/installed

# Locked versions first, then this checkout on top, so that two machines get the same libraries.
.venv/installed: requirements.lock pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check -r requirements.lock
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --editable .
	touch $@

demo: venv
	$(BIN)/longreach demo --out demo

test: venv
	$(BIN)/pytest

test-slow: venv
	$(BIN)/pytest -m "slow and not hil"

# The paper's program through daemon, CANopen and Modbus in a network namespace of its own (needs root).
hil: venv
	$(BIN)/pytest -m hil -s tests/hil/test_paper_line.py

# Hidden effects on a machine of other code, answers sealed; writes docs/blind.md. Continues where it stopped: BLIND="--cases 200 --workers 2".
blind: venv
	PYTHONPATH=tests $(BIN)/python -m blind $(BLIND)

lint: venv
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: venv
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: venv
	$(BIN)/python -m benchmarks

docs: venv
	$(BIN)/python -m config.reference

# FROM_VENV=.venv takes the libraries from there instead of the package index.
install:
	systemd/install.sh --destdir "$(DESTDIR)" --prefix "$(PREFIX)" --python "$(SERVICE_PYTHON)" --from-venv "$(FROM_VENV)"

uninstall:
	systemd/uninstall.sh --destdir "$(DESTDIR)" --prefix "$(PREFIX)"

clean:
	rm -rf .venv demo build *.egg-info
