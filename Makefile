# Set-up and the main jobs. Needs python3 (3.11 or newer) and make; everything else goes into .venv.
PYTHON ?= python3
BIN := .venv/bin
VENV_MB := 1000
# The service: where it goes, and the interpreter it runs with (no home directory: the unit cannot see those).
DESTDIR ?=
PREFIX ?= /opt/longreach
SERVICE_PYTHON ?= /usr/bin/python3

.PHONY: venv demo test test-slow hil blind lint format bench docs install uninstall clean

venv: .venv/installed

# Locked versions first, then this checkout on top, so that two machines get the same libraries.
.venv/installed: requirements.lock pyproject.toml
	@command -v $(PYTHON) >/dev/null || \
	  { echo "$(PYTHON) is not on the search path; longreach needs Python 3.11 or newer. Next: make venv PYTHON=/path/to/python3.11"; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "longreach needs Python 3.11 or newer; $(PYTHON) is $$($(PYTHON) -V 2>&1). Next: make venv PYTHON=python3.11"; exit 1; }
	@test -w . || \
	  { echo "$(CURDIR) cannot be written by $$(id -un 2>/dev/null || id -u)." \
	  "Next: ls -ld $(CURDIR) ; then make venv in a folder of your own, with a clone or a copy of this one"; exit 1; }
	@free_MB=$$(df -Pk . | awk 'NR == 2 {print int($$4 / 1024)}'); test -e .venv || test "$$free_MB" -ge $(VENV_MB) || \
	  { echo "The libraries take $(VENV_MB) MB and $$free_MB MB are free here. Next: df -h . ; make room, then make venv"; exit 1; }
	@echo "setting up .venv with the locked libraries: about a minute, once"
	@$(PYTHON) -m venv .venv || \
	  { echo "$(PYTHON) cannot make .venv: its venv module is missing (see above)." \
	  "Next: apt-get install python3-venv (Debian, Ubuntu), then make venv"; exit 1; }
	@$(BIN)/pip install --quiet --disable-pip-version-check -r requirements.lock && \
	  $(BIN)/pip install --quiet --disable-pip-version-check --no-deps --editable . || \
	  { echo "The libraries could not be installed: no network, no room on the disk, or a package index that does not answer (see above)." \
	  "Next: df -h . ; then make venv (behind a proxy: HTTPS_PROXY=http://host:port make venv)"; exit 1; }
	@touch $@

demo: venv
	$(BIN)/longreach demo --out demo

# Compiled modules are kept whatever the environment says (in build/, not beside the sources): hundreds of processes start in the tests.
test test-slow hil: export PYTHONDONTWRITEBYTECODE =
test test-slow hil: export PYTHONPYCACHEPREFIX = $(CURDIR)/build/pycache
# Every worker is a process of its own; threads of the linear algebra would only wait for each other.
test test-slow: export OPENBLAS_NUM_THREADS = 1

# The files with such tests, found without importing the others.
CLOCK = $(shell grep -rlE 'mark\.(device_)?clock' --include='test_*.py' tests)

# What needs no clock takes both processors, but gives way at once to the daemons of the tests that do (any user may ask for that).
BEHIND = $(shell command -v chrt >/dev/null && echo chrt --idle 0 || echo nice -n 19)

# One worker more than processors: some tests wait.
test: export PYTEST_XDIST_AUTO_NUM_WORKERS = $(shell $(PYTHON) -c 'import os; print(len(os.sched_getaffinity(0)) + 1)')

# Without xdist, `pytest` alone runs the same tests.
test: venv
	@mkdir -p build
	@$(BIN)/pytest -m "clock and not slow and not hil" $(CLOCK) >build/clock-tests.txt 2>&1 & on_the_clock=$$!; \
	$(BEHIND) $(BIN)/pytest -n auto --dist loadfile -m "not slow and not hil and not clock"; others=$$?; \
	wait $$on_the_clock; clock=$$?; cat build/clock-tests.txt; exit $$((others | clock))

test-slow: venv
	$(BIN)/pytest -m "slow and not hil"

# The paper's program through daemon, CANopen and Modbus in a network namespace of its own (needs root).
hil: venv
	$(BIN)/pytest -m hil -s tests/hil/test_paper_line.py

# Hidden effects on a machine of other code, answers sealed; writes docs/results/blind.md. Continues where it stopped: BLIND="--cases 200 --workers 2".
blind: venv
	$(BIN)/python -m tests.blind $(BLIND)

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
	$(BIN)/python -m daemon.checks_reference
	$(BIN)/python -m tests.docs.rooms_picture

# FROM_VENV=.venv takes the libraries from there instead of the package index.
install:
	daemon/systemd/install.sh --destdir "$(DESTDIR)" --prefix "$(PREFIX)" --python "$(SERVICE_PYTHON)" --from-venv "$(FROM_VENV)"

uninstall:
	daemon/systemd/uninstall.sh --destdir "$(DESTDIR)" --prefix "$(PREFIX)"

clean:
	rm -rf .venv demo build *.egg-info
