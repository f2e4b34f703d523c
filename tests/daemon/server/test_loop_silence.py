"""A loop that stands still is told by every answer: its last facts look like a healthy arm for as long as it hangs."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest

from config.errors import DaemonError
from config.loading.load import load_rig
from daemon.cli.operate.status_commands import status_view
from daemon.lockstep import LockstepRig
from daemon.server import loop_access
from tests.support.daemon.lockstep_requests import LockstepRequests


@pytest.fixture
def hung(tmp_path: Path) -> Iterator[LockstepRequests]:
    """Disarmed, and silent for 3.2 s."""
    with LockstepRig(load_rig("force_axis"), tmp_path) as rig:
        rig.cycles(10)
        requests = LockstepRequests(rig)
        requests.stands_still_s = 3.2
        yield requests


def test_status_says_for_how_long_and_to_press_the_hardware_e_stop(hung: LockstepRequests) -> None:
    status = asyncio.run(hung.handlers.status({}))
    assert status["loop"]["silent_s"] == 3.2
    shown = [line for line in status_view({**status, "log": {"path": ""}}) if "stood still for 3.2 s" in line]
    assert len(shown) == 1
    assert "Press the hardware e-stop" in shown[0]
    hung.stands_still_s = 0.0
    assert not any("stood still" in line for line in status_view(asyncio.run(hung.handlers.status({}))))


def test_it_stands_in_the_way_before_every_check(hung: LockstepRequests) -> None:
    first, *rest = asyncio.run(hung.handlers.checks({}))["checks"]
    assert (first["name"], first["ok"], first["value"], first["unit"]) == ("loop stands still", False, 3.2, "s")
    hung.stands_still_s = 0.0
    assert [row["name"] for row in asyncio.run(hung.handlers.checks({}))["checks"]] == [row["name"] for row in rest]


def test_a_command_that_is_not_carried_out_names_it(hung: LockstepRequests, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hung, "post", lambda command: 1_000_000)  # a number that the loop never comes to
    access = loop_access.LoopAccess(hung)
    with pytest.raises(DaemonError, match=r"stood still for 3\.2 s .*Press the hardware e-stop"):
        asyncio.run(access.send(None, lambda: True, 0.0))  # type: ignore[arg-type]
