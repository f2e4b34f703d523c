"""SIGTERM at the control process: what its first and its later ones mean."""

from __future__ import annotations

import pytest

from daemon.loop.command import CommandQueue
from daemon.modes.mode_machine import OperatorAction
from daemon.processes import control_process
from daemon.processes.control_process import SignalledCommands


def test_signals_that_come_together_are_one_controlled_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    """As Linux sends them when a parent with threads is killed; the second once cut the controlled stop short."""
    now_s = [10.0]
    monkeypatch.setattr(control_process.time, "monotonic", lambda: now_s[0])
    commands = SignalledCommands(CommandQueue())
    for later_s in (0.0, 0.001, 0.05):
        now_s[0] = 10.0 + later_s
        commands.on_signal(15, None)
    first = commands.poll()
    assert first is not None
    assert (first.action, first.leave) == (OperatorAction.NONE, True)
    assert commands.poll() is None
    now_s[0] = 10.5
    commands.on_signal(15, None)
    second = commands.poll()
    assert second is not None
    assert second.action is OperatorAction.DISARM
