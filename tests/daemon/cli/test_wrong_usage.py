"""Words that fit no command or option: what was wrong, the nearest that there is, and a next command that works."""

from __future__ import annotations

import json
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
        ("--si status", "longreach status: --si stands behind the command", "longreach status --si"),
        ("--si log info a.mcap", "longreach log info: --si stands behind the command", "longreach log info a.mcap --si"),
        ("play a.mcap --speed 2 uj", "view cannot be 'uj': nearest is 'ui'", "longreach play a.mcap --speed 2 ui"),
        ("replay a.mcap --rig b", "longreach replay: there is no option --rig", "longreach replay --help"),
        ("start jog --shaper zvdd", "--shaper cannot be 'zvdd': nearest is 'zvd'. One of: ", "longreach start jog --shaper zvd"),
        ("start jog --shaper=zvdd", "--shaper cannot be 'zvdd'", "longreach start jog --shaper=zvd"),
        ("start jog --repeat x", "longreach start: argument --repeat: 'x' is no whole number", "longreach start --help"),
        ("start jog --settle nan", "argument --settle: 'nan' is no number", "longreach start --help"),
        ("start jog --countdown 61", "(limit: 0 to 60 s): nearest is 60", "longreach start jog --countdown 60"),
        ("log plot a.mcap -o b.mcap", "another kind of file (limit: .png): nearest is b.png", "longreach log plot a.mcap -o b.png"),
        ("log plot a.mcap --output=.", "'.' is a folder: nearest is out.png", "longreach log plot a.mcap --output=out.png"),
        ("log export 'a b.mcap' -o x.xlsx", "(limit: .csv, .mat, .parquet): nearest is x.csv", "longreach log export 'a b.mcap' -o x.csv"),
        ("design force_axis --export a.txt", "(limit: .mat): nearest is a.mat", "longreach design force_axis --export a.mat"),
        ("start jog --countdown inf", "argument --countdown: 'inf' is no number", "longreach start --help"),
        ("start jog --countdown -1 --settle 0", "(limit: 0 to 60 s): nearest is 0", "longreach start jog --countdown 0 --settle 0"),
        ("simulate a b --seed 0 --repeat=0", "'0' is out of range (limit: at least 1)", "longreach simulate a b --seed 0 --repeat=1"),
        ("status --watch --interval -1", "'-1' is out of range", "longreach status --watch --interval 0.01"),
        ("ui --port 99999", "(limit: 0 to 65535): nearest is 65535", "longreach ui --port 65535"),
        ("play a.mcap ui --port 99999", "(limit: 0 to 65535)", "longreach play a.mcap ui --port 65535"),
        ("warm-up --hours 90", "(limit: 0.5 to 24 h)", "longreach warm-up --hours 24"),
        ("warm-up --hours nan", "argument --hours: 'nan' is no number", "longreach warm-up --help"),
        ("warm-up --moments noon", "argument --moments: 'noon' is no number", "longreach warm-up --help"),
        ("oil-table --temperatures 300", "(limit: -20 to 90 degC)", "longreach oil-table --temperatures 90"),
        ("oil-table --temperatures 20,nan", "'nan' is no number", "longreach oil-table --help"),
        ("shape --error nan", "argument --error: 'nan' is no number", "longreach shape --help"),
        ("log report a.mcap --run 0", "(limit: at least 1)", "longreach log report a.mcap --run 1"),
        ("log incident a.mcap --fault 0", "(limit: at least 1)", "longreach log incident a.mcap --fault 1"),
        ("log diff a.mcap b.mcap --runs 1 0", "(limit: at least 1)", "longreach log diff a.mcap b.mcap --runs 1 1"),
        ("runs . --last -3", "(limit: at least 1)", "longreach runs . --last 1"),
        ("device watch a b --every '-1 s'", "(limit: 0 to 3600 s)", "longreach device watch a b --every 0"),
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


def test_an_optional_word_may_stand_behind_an_option() -> None:
    for typed in ("play a.mcap ui --speed 2", "play a.mcap --speed 2 ui", "play --speed 2 a.mcap ui"):
        found = build_parser().parse_args(shlex.split(typed))
        assert (found.log, found.view, found.speed) == ("a.mcap", "ui", 2.0)
    assert build_parser().parse_args(["device", "read", "rig.yaml", "--json", "encoder"]).device == "encoder"


@pytest.mark.parametrize("typed", ["statsu --json", "--json status", "start jog --settle nan --json", "log --json", "log info --json"])
def test_wrong_usage_is_json_for_scripts(typed: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as refused:
        main(shlex.split(typed))
    assert refused.value.code == EXIT_USAGE
    told = capsys.readouterr()
    assert told.err == ""
    error = json.loads(told.out)["error"]
    assert error["class"] == "UsageError"
    assert "`longreach" in error["next_step"]
