"""The screen of `top`: what is old, or of a log, is never shown as the rig now."""

from __future__ import annotations

from typing import Any

import pytest
from rich.console import Console

from config.loading.load import load_rig
from daemon.checks.interlocks import rig_facts
from daemon.cycle.timing import WORDS, Timing
from daemon.live.source.scene import scene
from daemon.live.terminal import glance
from daemon.live.terminal.glance import Glance
from daemon.server.event_history import EventHistory
from daemon.server.live_values import LiveValues
from daemon.server.status import StatusView

LOADED = load_rig("ornl_testbed")
RIG = LOADED.rig
FACTS = rig_facts(RIG)


def shown(screen: Glance) -> str:
    console = Console(width=120, height=40, record=True, file=open("/dev/null", "w"))  # noqa: SIM115
    console.print(screen.lines(40))
    return console.export_text()


def screen_of(**rig: Any) -> Glance:
    live, view = LiveValues(RIG, FACTS), StatusView(RIG, FACTS, Timing([0] * WORDS))
    values = FACTS.blank()
    screen = Glance()
    answer = {"name": RIG.name, "text": LOADED.text, "signals": live.signals, **rig}
    screen.take({"lost": "", "rig": scene(answer)})
    screen.take({"status": view.status(values, 0.0, EventHistory()), "samples": [[0.0, *live.row(values)]], "checks": []})
    return screen


def test_values_that_no_longer_come_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr(glance.time, "monotonic", lambda: now[0])
    screen = screen_of()
    assert "NO LIVE DATA" not in shown(screen)
    now[0] += glance.STALE_S + 0.1
    assert "NO LIVE DATA: the loop makes no new cycle" in shown(screen)
    assert "e-stop: longreach estop" in shown(screen)


def test_a_played_log_is_not_taken_for_the_rig() -> None:
    said = shown(screen_of(played="run7.mcap"))
    assert "PLAYED from run7.mcap, not the rig" in said
    assert "longreach stop" not in said
