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


def shown(screen: Glance, width: int = 120) -> str:
    console = Console(width=width, height=40, record=True, file=open("/dev/null", "w"))  # noqa: SIM115
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


def test_what_runs_stands_on_a_narrow_screen_beside_a_long_name() -> None:
    said = shown(screen_of(played="ornl_testbed-20000101-000000.recovered.mcap"), width=60)
    assert "no run yet" in said


def test_why_it_stopped_stands_on_a_narrow_screen() -> None:
    screen = screen_of()
    status = StatusView(RIG, FACTS, Timing([0] * WORDS)).status(FACTS.blank(), 0.0, EventHistory())
    fault = {"text": "rotary: following error 0.31 rad above 0.30 rad"}
    screen.take({"status": {**status, "mode": "fault", "fault": fault}})
    assert f"fault: {fault['text']}" in shown(screen, width=60)
