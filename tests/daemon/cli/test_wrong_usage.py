"""Words that fit no command or option: what was wrong, the nearest that there is, and a next command that works."""

from __future__ import annotations

import shlex

import pytest

from config.errors import EXIT_USAGE
from daemon.cli.command_line import build_parser
from daemon.cli.main import main


@pytest.mark.parametrize(
    ("typed", "said", "next_command"),
    [
        ("statsu", "longreach: there is no command 'statsu': nearest is 'status'", "longreach status --help"),
        ("log inf a.mcap", "longreach log: there is no command 'inf': nearest is 'info'", "longreach log info --help"),
        ("status --wach", "longreach status: there is no option --wach: nearest is --watch", "longreach status --watch"),
        ("log plot a.mcap --singals=x", "longreach log plot: there is no option --singals", "longreach log plot a.mcap --signals=x"),
        ("replay a.mcap --rig b", "longreach replay: there is no option --rig", "longreach replay --help"),
        ("start jog --shaper zvdd", "--shaper cannot be 'zvdd': nearest is 'zvd'. One of: ", "longreach start jog --shaper zvd"),
        ("start jog --shaper=zvdd", "--shaper cannot be 'zvdd'", "longreach start jog --shaper=zvd"),
        ("start jog --repeat x", "longreach start: argument --repeat: invalid int value: 'x'", "longreach start --help"),
        ("arm now", "longreach arm: 'now' is one word too many", "longreach arm --help"),
        ("gap find --rig a.yaml", "longreach gap find: the following arguments are required: --log", "longreach gap find --help"),
        ("log", "longreach log: the following arguments are required: VERB", "longreach log --help"),
        ("", "longreach: the following arguments are required: COMMAND", "longreach --help"),
    ],
)  # fmt: skip
def test_what_is_wrong_and_what_to_type(typed: str, said: str, next_command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as refused:
        main(shlex.split(typed))
    assert refused.value.code == EXIT_USAGE
    told = capsys.readouterr().err.splitlines()
    assert said in told[-2]
    assert told[-1] == f"next: {next_command}"
    words = shlex.split(next_command)[1:]
    if "--help" in words:
        with pytest.raises(SystemExit) as helped:
            build_parser().parse_args(words)
        assert helped.value.code == 0
    else:
        build_parser().parse_args(words)
