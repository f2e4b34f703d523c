"""The e-stop key of `jog` while the arm slows down, and what is said when it is not delivered."""

from __future__ import annotations

import argparse
import threading
from typing import Any

import pytest

from config.errors import DaemonError
from daemon.cli.jog import jog_command
from daemon.cli.jog.keyboard import Key


class SlowEnd:
    """A run that ends once it was stopped."""

    def __init__(self) -> None:
        self.stopped = threading.Event()

    def end(self) -> dict[str, Any]:
        assert self.stopped.wait(20)
        return {"run": 1, "validity": "invalid", "reason": "e-stop was asked for"}


class Pressed:
    """A keyboard on which one key after the other is pressed."""

    def __init__(self, *names: str) -> None:
        self._names = list(names)

    def keys(self, wait_s: float) -> list[Key]:
        threading.Event().wait(wait_s)
        return [Key(self._names.pop(0))] if self._names else []


@pytest.mark.parametrize("key", ["e", "E"])
def test_it_works_while_the_arm_slows_down(monkeypatch: pytest.MonkeyPatch, key: str) -> None:
    stream: Any = SlowEnd()
    keyboard: Any = Pressed("x", key)
    monkeypatch.setattr(jog_command, "ask_to_stop", lambda *given: stream.stopped.set())
    assert jog_command._ended(argparse.Namespace(), stream, keyboard, False)["reason"] == "e-stop was asked for"


def test_that_it_was_not_delivered_is_said_at_once(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    stream: Any = SlowEnd()
    keyboard: Any = Pressed("e")

    def hangs(*given: object) -> None:
        threading.Timer(0.1, stream.stopped.set).start()
        raise DaemonError("the e-stop was NOT delivered", next_step="Press the hardware e-stop.")

    monkeypatch.setattr(jog_command, "ask_to_stop", hangs)
    jog_command._ended(argparse.Namespace(), stream, keyboard, False)
    assert "the e-stop was NOT delivered. Press the hardware e-stop." in capsys.readouterr().err
    with pytest.raises(DaemonError, match="NOT delivered"):
        jog_command._ended(argparse.Namespace(), stream, keyboard, True)
