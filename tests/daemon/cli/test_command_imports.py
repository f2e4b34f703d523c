"""Which libraries a command imports before and while it works: the ones an operator waits for have the standard library alone."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

OF_THE_HOUSE = {"config", "daemon", "servo_control", "sim_backend", "drivers", "recording", "tuning", "gap"}
IMPORTS_OF = """
import sys, json
before = set(sys.modules)
sys.argv = ["longreach", *sys.argv[1:]]
from daemon.cli.main import main
try:
    main()
except SystemExit:
    pass
from daemon.cli.commands import COMMANDS, CommandParser
%s
print(json.dumps(sorted({name.partition(".")[0] for name in set(sys.modules) - before})), file=sys.stderr)
"""


def foreign_imports(*words: str, home: Path, after: str = "") -> set[str]:
    """Top-level packages outside the standard library and the house that `longreach WORDS` imports, in a process of its own."""
    environment = {"PATH": "/usr/bin:/bin", "HOME": str(home), "XDG_RUNTIME_DIR": str(home)}
    found = subprocess.run([sys.executable, "-c", IMPORTS_OF % after, *words], capture_output=True, text=True, check=True, env=environment)
    return set(json.loads(found.stderr.splitlines()[-1])) - sys.stdlib_module_names - OF_THE_HOUSE


def test_help_imports_no_library(tmp_path: Path) -> None:
    assert foreign_imports("--help", home=tmp_path) == set()


def test_the_options_of_every_command_need_no_library(tmp_path: Path) -> None:
    """One process for all of them: shell completion asks for all options at once."""
    assert foreign_imports("--help", home=tmp_path, after="for command in COMMANDS: CommandParser(options=command.options).load()") == set()


@pytest.mark.parametrize("name", ["status", "why", "maneuvers", "events", "arm", "disarm", "reset", "estop", "stop"])
def test_a_command_that_asks_the_daemon_needs_no_library(name: str, tmp_path: Path) -> None:
    """No daemon answers here; with one the answer is JSON. test_quick_commands sees them with a daemon."""
    assert foreign_imports("--socket", str(tmp_path / "none.sock"), name, home=tmp_path) == set()
