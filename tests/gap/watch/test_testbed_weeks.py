"""The two-joint testbed over eight weeks of its everyday maneuver, the oil at another temperature each time: a leak that grows and friction
that steps, at the same joint, and nothing else."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from config.loading.load import LoadedRig, load_rig, rig_from_text
from daemon.lockstep import run_lockstep
from gap.watch.watch import watch
from recording.files.export import export
from recording.files.reader import read_log

LEAKAGE, FRICTION = "rotary.cross_leakage.conductance", "rotary.coulomb_friction.friction"
STATED_LEAKAGE, STATED_FRICTION_Nm = 4.45e-12, 105.0
GROWTH, WORN_FRICTION_Nm, STEP_AT = 0.25, 150.0, 4  # of the stated leakage, a week; from this log on
OIL_degC = (25, 48, 33, 40, 55, 30, 45, 37)
WEEK_DAYS = 7.0


def leakage(week: int) -> float:
    return STATED_LEAKAGE * (1.0 + GROWTH * week)


def worn(text: str, week: int) -> str:
    changes = [
        ("conductance: 4.45e-12", f"conductance: {leakage(week):.6g}"),
        ("initial_temperature: 40 degC", f"initial_temperature: {OIL_degC[week]} degC"),
    ]
    if week >= STEP_AT:
        changes.append(("friction: 105 N*m", f"friction: {WORN_FRICTION_Nm:g} N*m"))
    for stated, now in changes:
        head, found, tail = text.rpartition(stated)  # the plant stands last in the file
        assert found, stated
        text = head + now + tail
    return text


def record(folder: Path, loaded: LoadedRig, week: int) -> None:
    text = worn(loaded.text, week)
    machine = LoadedRig(rig_from_text(text, loaded.path), text, loaded.path)
    (log,) = run_lockstep(machine, [{"maneuver": "paper_line"}], folder / f"week{week}", seed=100 + week)
    moment = datetime(2026, 3, 2, 9, tzinfo=UTC) + timedelta(days=WEEK_DAYS * week)
    export(read_log(log), folder / f"testbed-{moment:%Y%m%d-%H%M%S}.csv")


@pytest.mark.slow
@pytest.mark.long
def test_what_wears_alarms_and_all_else_is_steady(tmp_path: Path) -> None:
    loaded = load_rig("ornl_testbed")
    for week in range(len(OIL_degC)):
        record(tmp_path / "logs", loaded, week)
    found = watch("ornl_testbed", tmp_path / "logs", tmp_path / "out", lambda _: None)
    assert len(found.fits) == len(OIL_degC)
    assert sorted(one.number.name for one in found.alarms) == [FRICTION, LEAKAGE]
    told = {one.number.name: one for one in found.numbers if one.course is not None}
    assert len(told) >= 15
    assert {name: one.word for name, one in told.items() if one.word != "steady"} == {FRICTION: "steps", LEAKAGE: "drifts"}
    friction, leak = told[FRICTION].course, told[LEAKAGE].course
    assert friction is not None
    assert leak is not None
    assert friction.steps == (STEP_AT,)
    height, width = friction.step(0)
    assert height == pytest.approx(WORN_FRICTION_Nm - STATED_FRICTION_Nm, abs=width)
    slope, half = leak.slope
    assert slope == pytest.approx(GROWTH * STATED_LEAKAGE / WEEK_DAYS, abs=half)
    truth = {name: one.number.free.start for name, one in told.items()} | {LEAKAGE: leakage(len(OIL_degC) - 1), FRICTION: WORN_FRICTION_Nm}
    held = [abs(one.now[0] - truth[name]) < one.now[1] for name, one in told.items()]
    assert np.mean(held) > 0.8
