"""`longreach why LOG --at T` of a run driven by hand: from the set points in the log come the very numbers the loop's checks read."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import nan
from pathlib import Path

import numpy as np
import pytest

from daemon.checks.declared.driving_by_hand import CHECKS, FACTS
from daemon.checks.interlocks import rig_facts
from daemon.checks.past_checks import checks_at, walked
from daemon.cli.main import main
from daemon.lockstep import LockstepRig
from daemon.modes.mode_machine import OperatorAction
from recording.files.reader import Log, open_rig, read_log
from servo_control.signals import Mode, SetPoint, Wanted
from tests.support.daemon.rigs import JOG, simple_rig
from tests.support.daemon.simple_device import SimpleDevice

Scene = Callable[["Hand"], None]


class Hand:
    """Drives the rig and notes what the loop's checks read in every cycle: the facts that the cycle before left."""

    def __init__(self, rig: LockstepRig, device: SimpleDevice) -> None:
        self.rig, self.device, self.read = rig, device, {}
        cycle = rig.loop.cycle

        def noting() -> None:
            found = tuple(rig.value(fact) for fact in FACTS)
            cycle()
            self.read[int(rig.value("cycle"))] = found

        rig.loop.cycle = noting  # type: ignore[method-assign]

    def begin(self) -> None:
        self.run = self.rig.stream()
        self.rig.until(lambda: self.rig.mode is Mode.RUNNING)

    def send(self, wanted: int, *values: float, late_s: float = 0.0, cycles: int = 30) -> None:
        self.rig.set_points.post(SetPoint(self.run, wanted, values, late_s))
        self.rig.cycles(cycles)

    def rest(self) -> None:
        self.rig.until(lambda: self.rig.mode is Mode.HOLDING)
        self.rig.cycles(20)


def ended(hand: Hand) -> None:
    hand.send(Wanted.RATE, 0.3, 0.0)
    hand.send(Wanted.TIP, 0.1, 0.1)
    hand.send(Wanted.TARGET, 0.1, 1.0, late_s=0.01)
    hand.send(Wanted.END)
    hand.rest()


def silent(hand: Hand) -> None:
    hand.send(Wanted.RATE, 0.3, 0.0)
    hand.rest()


def never_heard(hand: Hand) -> None:
    hand.rest()


def late(hand: Hand) -> None:
    hand.send(Wanted.RATE, 0.3, 0.0)
    hand.send(Wanted.RATE, 0.3, 0.0, late_s=0.4)
    hand.rest()


def not_finite(hand: Hand) -> None:
    hand.send(Wanted.RATE, nan, 0.0)
    hand.rest()


def too_far(hand: Hand) -> None:
    hand.send(Wanted.TARGET, 2.9, 1.0)
    hand.rest()


def hung_up(hand: Hand) -> None:
    hand.send(Wanted.RATE, 0.3, 0.0)
    hand.send(Wanted.CLIENT_LEFT)
    hand.rest()


def stopped(hand: Hand) -> None:
    hand.send(Wanted.RATE, 0.3, 0.0)
    hand.rig.post(OperatorAction.STOP)
    hand.send(Wanted.RATE, 0.3, 0.0)
    hand.rest()


def broken_off(hand: Hand) -> None:
    hand.send(Wanted.RATE, 0.3, 0.0)
    hand.device.override["rotary.position"] = nan
    hand.rig.until(lambda: hand.rig.mode is Mode.FAULT)
    hand.rig.cycles(2100)


SCENES = (ended, silent, never_heard, late, not_finite, too_far, hung_up, stopped, broken_off)
SAID = {silent: "set points arriving", never_heard: "set points arriving", late: "set point in time", not_finite: "set point usable",
        too_far: "set point in range", hung_up: "driving client"}  # fmt: skip


def driven(directory: Path, scene: Scene) -> tuple[Log, dict[int, tuple[float, ...]]]:
    """A run of the scene, then another one and a program, all in one log."""
    with simple_rig(directory) as (rig, device):
        hand = Hand(rig, device)
        rig.arm()
        hand.begin()
        scene(hand)
        if rig.mode is Mode.HOLDING:
            hand.begin()
            ended(hand)
            rig.start(JOG)
            rig.until(lambda: not rig.loop.keeper.run.active)
            rig.disarm()
    return read_log(rig.recorder.finished[-1]), hand.read


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.__name__)
def test_every_row_has_the_numbers_that_the_loop_read(tmp_path: Path, scene: Scene) -> None:
    log, read = driven(tmp_path, scene)
    rig = open_rig(log)
    facts = rig_facts(rig)
    at = [facts.index(name) for name in FACTS]
    found = [tuple(values[index] for index in at) for values in walked(log, rig, facts, 0, log.cycles - 1)]
    assert found == [read[cycle] for cycle in log.columns["cycle"].tolist()]
    assert any(any(numbers) for numbers in found)


@pytest.mark.parametrize("scene", SAID, ids=lambda scene: scene.__name__)
def test_at_the_stop_the_check_that_made_it_has_failed(tmp_path: Path, scene: Scene) -> None:
    """Asked at one moment, and of a row that lies farther from the beginning of the run than any rule remembers."""
    log, _ = driven(tmp_path, scene)
    stop = next(event for event in log.events if event.name == "mode" and "→ stopping" in event.text)
    named = {check.name for check in CHECKS}
    rows = {check["name"]: check for check in checks_at(log, stop.t_s).checks if check["name"] in named}
    assert set(rows) == named
    assert [name for name, row in rows.items() if row["ok"] is False] == [SAID[scene]]
    assert f"{rows[SAID[scene]]['value']:.6g}" in stop.text


def test_the_command_says_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, _ = driven(tmp_path, late)
    stop = next(event for event in log.events if event.name == "mode" and "→ stopping" in event.text)
    assert main(["why", str(log.path), "--at", f"{stop.t_s:.6f}"]) == 1
    assert "NO  set point in time" in capsys.readouterr().out


def test_a_run_whose_request_is_lost_is_not_judged(tmp_path: Path) -> None:
    log, _ = driven(tmp_path, ended)
    log.attachments.pop("run-1.json")
    unknown = {check["name"] for check in checks_at(log, None).checks if check["ok"] is None}
    assert {check.name for check in CHECKS} <= unknown


def without(log: Log, rows: range) -> Log:
    columns = {name: np.delete(values, rows) for name, values in log.columns.items()}
    return replace(log, columns=columns, time_ns=np.delete(log.time_ns, rows))


@pytest.mark.parametrize("lost", ["before it", "its beginning", "within it", "its end"])
def test_a_motion_of_which_cycles_are_lost_is_not_judged(tmp_path: Path, lost: str) -> None:
    """For the judge remembers; of what is lost before a motion it remembers nothing."""
    log, _ = driven(tmp_path, ended)
    first, last = (int(at) for at in np.flatnonzero((log.columns["segment"] != 0) & (log.columns["maneuver"] == 1))[[0, -1]])
    start = {"before it": first - 30, "its beginning": first - 5, "within it": last - 40, "its end": last - 5}[lost]
    unknown = {check["name"] for check in checks_at(without(log, range(start, start + 15)), None).checks if check["ok"] is None}
    assert {check.name for check in CHECKS} & unknown == (set() if lost == "before it" else {check.name for check in CHECKS})


def test_a_log_that_begins_within_a_motion_is_judged_from_the_state_in_it_only(tmp_path: Path) -> None:
    log, _ = driven(tmp_path, ended)
    first = int(np.flatnonzero(log.columns["segment"])[0])
    unknown = {check["name"] for check in checks_at(without(log, range(first + 20)), None).checks if check["ok"] is None}
    assert {check.name for check in CHECKS} <= unknown
