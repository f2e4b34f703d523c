"""A wrong Python, no network, a full disk, missing rights, no terminal: each is made so here, and each is a sentence with what to do.

The conditions are real: a small tmpfs, a folder that may not be written, an empty network namespace. What the system does not let this
user make is skipped.
"""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

import daemon
from config.loading.load import load_rig
from daemon.lockstep import run_lockstep

CHECKOUT = Path(daemon.__file__).parents[1]
LONGREACH = [sys.executable, "-m", "daemon.cli.main"]
DAEMON = [sys.executable, "-m", "daemon.processes.supervisor"]
WITHOUT_OVERRIDE = "-dac_override,-dac_read_search"  # root passes over the rights of files by these
AS_ROOT = ["setpriv", f"--bounding-set={WITHOUT_OVERRIDE}", f"--inh-caps={WITHOUT_OVERRIDE}"]
UNPRIVILEGED = AS_ROOT if os.geteuid() == 0 else []
NAMESPACE = ["unshare"] if os.geteuid() == 0 else ["unshare", "--map-root-user"]


def works(command: Sequence[str]) -> bool:
    return shutil.which(command[0]) is not None and subprocess.run(command, capture_output=True, check=False).returncode == 0


needs_mount = pytest.mark.skipif(not works([*NAMESPACE, "--mount", "true"]), reason="no mount namespace for this user")
needs_net = pytest.mark.skipif(not works([*NAMESPACE, "--net", "true"]), reason="no network namespace for this user")
needs_rights = pytest.mark.skipif(bool(UNPRIVILEGED) and not works([*UNPRIVILEGED, "true"]), reason="root cannot give up its rights here")


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short log of the testbed, longer than the small disk."""
    hold = {"maneuver": {"name": "jog"}}
    return run_lockstep(load_rig("ornl_testbed"), [hold], tmp_path_factory.mktemp("log"))[0]


def refusal(command: Sequence[str], **keywords: object) -> str:
    """What a command that is refused says, all of it; a traceback is no refusal."""
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, stdin=subprocess.DEVNULL, check=False, **keywords)  # type: ignore[call-overload]
    said = str(done.stdout + done.stderr)
    assert done.returncode in (1, 2, 3), said
    assert "Traceback" not in said
    return said


@pytest.mark.parametrize("module", ["daemon.cli.main", "daemon.processes.supervisor"])
def test_an_older_python_is_named_with_what_to_type(module: str) -> None:
    older = f"import runpy, sys; sys.version_info = (3, 10, 4, 'final', 0); runpy.run_module({module!r}, run_name='__main__')"
    said = refusal([sys.executable, "-c", older], cwd=CHECKOUT)
    assert "longreach needs Python 3.11 or newer; this is 3.10" in said
    assert "make venv PYTHON=python3.11" in said


def test_older_pythons_can_read_the_lines_that_refuse_them() -> None:
    ast.parse(Path(daemon.__file__).read_text(encoding="utf-8"), feature_version=(3, 4))
    assert Path(daemon.__file__).read_text(encoding="ascii")


@pytest.mark.parametrize("name", ["python3.8", "python3.9", "python3.10"])
def test_a_real_older_python_where_there_is_one(name: str) -> None:
    if not works([name, "-V"]):
        pytest.skip(f"no {name} here")
    assert "longreach needs Python 3.11" in refusal([name, "-m", "daemon.cli.main", "status"], cwd=CHECKOUT)


def checkout(directory: Path, lock: str) -> Path:
    """What `make venv` needs of a clone, with a lock file of one line."""
    shutil.copy(CHECKOUT / "Makefile", directory)
    shutil.copy(CHECKOUT / "pyproject.toml", directory)
    (directory / "requirements.lock").write_text(lock)
    return directory


def test_make_says_which_python_it_needs_and_makes_nothing(tmp_path: Path) -> None:
    stub = tmp_path / "python3.10"
    stub.write_text('#!/bin/sh\n[ "$1" = -V ] && echo "Python 3.10.4" && exit 0\nexit 1\n')
    stub.chmod(0o755)
    said = refusal(["make", "-C", str(checkout(tmp_path, "")), "venv", f"PYTHON={stub}"])
    assert f"longreach needs Python 3.11 or newer; {stub} is Python 3.10.4. Next: make venv PYTHON=python3.11" in said
    assert not (tmp_path / ".venv").exists()


@pytest.mark.slow
def test_make_without_network_says_so_and_can_be_run_again(tmp_path: Path) -> None:
    alone = {key: value for key, value in os.environ.items() if not key.startswith("PIP_")}
    alone |= {"PIP_CONFIG_FILE": os.devnull, "PIP_INDEX_URL": "http://127.0.0.1:9/simple", "PIP_RETRIES": "0", "PIP_NO_CACHE_DIR": "1"}
    said = refusal(["make", "-C", str(checkout(tmp_path, "canopen==2.4.1\n")), "venv", f"PYTHON={sys.executable}"], env=alone)
    assert "The libraries could not be installed: no network" in said
    assert "then make venv" in said
    assert not (tmp_path / ".venv" / "installed").exists()


def on_small_disk(directory: Path, *words: str) -> list[str]:
    """A command with 64 KiB of tmpfs at `directory`; what is left there afterwards is listed in DIRECTORY.left."""
    directory.mkdir()
    script = 'mount -t tmpfs -o size=64k none "$0" || exit 77; "$@"; status=$?; ls -A "$0" >"$0.left"; exit $status'
    return [*NAMESPACE, "--mount", "sh", "-c", script, str(directory), *words]


@needs_mount
def test_make_without_room_says_how_much_it_needs_before_it_begins(tmp_path: Path) -> None:
    small = tmp_path / "small"
    script = 'cp "$1/Makefile" "$1/pyproject.toml" "$1/requirements.lock" "$2" && make -C "$2" venv PYTHON="$3"'
    sources = checkout(tmp_path, "")
    said = refusal(on_small_disk(small, "sh", "-c", script, "sh", str(sources), str(small), sys.executable))
    assert "The libraries take 1000 MB and 0 MB are free here. Next: df -h . ; make room, then make venv" in said
    assert ".venv" not in small.with_suffix(".left").read_text()


@needs_rights
def test_make_where_nothing_may_be_written_says_whose_folder_is_wanted(tmp_path: Path) -> None:
    folder = checkout(tmp_path, "")
    folder.chmod(0o555)
    said = refusal([*UNPRIVILEGED, "make", "-C", str(folder), "venv", f"PYTHON={sys.executable}"])
    folder.chmod(0o755)
    assert f"{folder} cannot be written by " in said
    assert f"Next: ls -ld {folder} ; then make venv in a folder of your own" in said
    assert not (folder / ".venv").exists()


@pytest.mark.slow
@needs_mount
@pytest.mark.parametrize(("verb", "name"), [("export", "x.csv"), ("export", "x.mat"), ("plot", "x.png")])
def test_a_full_disk_leaves_nothing_half_written(log: Path, tmp_path: Path, verb: str, name: str) -> None:
    small = tmp_path / "small"
    said = refusal(on_small_disk(small, *LONGREACH, "log", verb, str(log), "-o", str(small / name)))
    assert f"{small / name}: the " in said
    assert "cannot be written: No space left on device. The disk is full: make room" in said
    assert "next: df -h" in said
    assert small.with_suffix(".left").read_text() == ""


@pytest.mark.slow
@needs_mount
def test_nothing_moves_while_there_is_no_room_for_the_log(tmp_path: Path) -> None:
    small = tmp_path / "small"
    said = refusal(on_small_disk(small, *LONGREACH, "simulate", "ornl_testbed", "jog", "-o", str(small / "x.mcap")))
    assert "disk space (log directory)" in said
    assert "Move old logs away" in said
    assert "next: df -h" in said


@pytest.fixture
def closed(tmp_path: Path) -> Path:
    """A folder that may not be written."""
    folder = tmp_path / "closed"
    folder.mkdir()
    folder.chmod(0o555)
    return folder


@needs_rights
def test_a_folder_that_may_not_be_written(log: Path, closed: Path) -> None:
    said = refusal([*UNPRIVILEGED, *LONGREACH, "log", "export", str(log), "-o", str(closed / "x.csv")])
    assert f"{closed / 'x.csv'}: the table cannot be written: Permission denied. Choose another place" in said
    assert f"next: ls -ld {closed}" in said


@needs_rights
def test_a_report_is_refused_before_it_simulates_where_no_page_can_stand(log: Path, tmp_path: Path) -> None:
    folder = tmp_path / "closed"
    folder.mkdir()
    copy = Path(shutil.copy(log, folder / "a.mcap"))
    folder.chmod(0o555)
    said = refusal([*UNPRIVILEGED, *LONGREACH, "log", "report", str(copy)])
    assert said.startswith(f"longreach: {folder}: no page can be written here: Permission denied. A page stands beside its log")
    assert "Choose another place" not in said
    assert said.endswith(f"next: ls -ld {folder}\n")


@pytest.mark.slow
@needs_rights
def test_a_log_that_may_not_be_read(log: Path, tmp_path: Path) -> None:
    secret = Path(shutil.copy(log, tmp_path / "secret.mcap"))
    secret.chmod(0)
    said = refusal([*UNPRIVILEGED, *LONGREACH, "log", "info", str(secret)])
    assert f"{secret}: the log cannot be opened: Permission denied." in said
    assert f"next: ls -ld {secret}" in said


@needs_rights
@pytest.mark.parametrize("option", ["--log-dir", "--runtime-dir"])
def test_a_daemon_that_may_not_write_its_places_says_which(closed: Path, tmp_path: Path, option: str) -> None:
    places = {"--log-dir": str(tmp_path / "logs"), "--runtime-dir": str(tmp_path / "run"), option: str(closed / "below")}
    said = refusal([*UNPRIVILEGED, *DAEMON, "ornl_testbed", *(word for pair in places.items() for word in pair)])
    assert f"longreachd: {closed / 'below'}" in said
    assert "Permission denied" in said
    assert said.count("\n") == 2  # one sentence, and the command to type next
    assert "\nnext: ls -ld " in said


@pytest.mark.slow
@needs_net
def test_a_rig_on_a_bus_that_this_machine_lacks(tmp_path: Path) -> None:
    places = ["--log-dir", str(tmp_path / "logs"), "--runtime-dir", str(tmp_path / "run")]
    said = refusal([*NAMESPACE, "--net", *DAEMON, "ornl_testbed_can", *places])
    assert "socketcan can0: the CAN bus cannot be opened" in said
    assert "ip link set can0 up type can bitrate" in said


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["new-rig", "axis"], "--kind is missing (limit: cylinder or rotary or arm). Add --kind cylinder."),
        (["commission", "ornl_testbed"], "nobody can be asked before motion. Run it on a terminal, or with --yes."),
    ],
)
def test_a_question_without_a_terminal_names_the_option(words: list[str], sentence: str, tmp_path: Path) -> None:
    said = refusal([*LONGREACH, *words], cwd=tmp_path, env={key: value for key, value in os.environ.items() if key != "TERM"})
    assert sentence in said
    assert "next: " in said
    assert not list(tmp_path.iterdir())
