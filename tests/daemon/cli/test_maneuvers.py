"""`longreach maneuvers`: what the rig can run; the rest only when asked, with the reason."""

from __future__ import annotations

import json

import pytest

from config.stated_sentences import StatedSentences
from daemon.cli.main import main
from daemon.cli.operate import status_commands

MANEUVERS = [
    {"name": "hold", "kind": "hold", "description": "Nothing moves", "reason": ""},
    {"name": "paper_line", "kind": "straight_line", "description": "The line", "reason": "extension 1.016 m is above the limit 0.5 m."},
]


class Answers:
    """A connection to a daemon that knows these maneuvers; its rig file states extensions in inches."""

    def __init__(self, maneuvers: list[dict[str, str]]) -> None:
        self._maneuvers = maneuvers

    def __enter__(self) -> Answers:
        return self

    def __exit__(self, *error: object) -> None:
        """Nothing to close."""

    def call(self, method: str) -> dict[str, list[dict[str, str]]]:
        return {method: self._maneuvers}

    def sentences(self) -> StatedSentences:
        return StatedSentences({"prismatic": {"m": ("in", 1 / 0.0254, 0.0)}})


@pytest.fixture(autouse=True)
def _daemon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(status_commands, "connect", lambda arguments: Answers(MANEUVERS))


def test_only_those_that_the_rig_can_run(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["maneuvers"]) == 0
    out = capsys.readouterr().out
    assert "hold" in out
    assert "paper_line" not in out
    assert "1 more cannot run on this rig: `longreach maneuvers --all` says why" in out


def test_all_of_them_with_the_reason(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["maneuvers", "--all"]) == 0
    assert "not on this rig: paper_line: extension 40 in is above the limit 19.69 in." in capsys.readouterr().out


def test_scripts_get_all_of_them(capsys: pytest.CaptureFixture[str]) -> None:
    main(["maneuvers", "--json"])
    assert json.loads(capsys.readouterr().out) == MANEUVERS


def test_a_daemon_of_before_which_gives_no_reason(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    old = [{key: maneuver[key] for key in ("name", "kind", "description")} for maneuver in MANEUVERS]
    monkeypatch.setattr(status_commands, "connect", lambda arguments: Answers(old))
    assert main(["maneuvers"]) == 0
    assert "paper_line" in capsys.readouterr().out
