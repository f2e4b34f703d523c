"""Shell completion, asked of the shell itself."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from daemon.cli.commands import COMMANDS
from daemon.cli.main import main

ASK = """{script}
COMP_WORDS=({words}); COMP_CWORD={at}; _longreach; echo "${{COMPREPLY[@]}}"
"""


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here")
@pytest.mark.parametrize(
    ("words", "at", "expected"),
    [
        ("longreach es", 1, ["estop"]),
        ("longreach arm --a", 2, ["--all"]),
        ("longreach log ch", 2, ["check"]),
        ("longreach completion z", 2, ["zsh"]),
    ],
)
def test_bash_completes_commands_options_and_verbs(words: str, at: int, expected: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", "bash"]) == 0
    script = ASK.format(script=capsys.readouterr().out, words=words, at=at)
    answer = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert answer.stdout.split() == expected


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_the_other_shells_get_every_command(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    said = capsys.readouterr().out
    assert all(command.name in said for command in COMMANDS)
