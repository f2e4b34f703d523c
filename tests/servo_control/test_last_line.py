"""The reference limit is the last line: of a run that was planned for a rig that may do more, the controller makes what its own rig may."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from config.schema.rig import Rig
from servo_control.planning.planning import plan_run
from tests.support.servo_control.ideal_arm import PERIOD_S, IdealArm
from tests.support.servo_control.testbed_runs import INCH, content, request

HOME = [0.0, 30 * INCH]


def with_rotary(rig: Rig, **change: object) -> Rig:
    return rig.model_copy(update={"joints": {**rig.joints, "rotary": rig.joints["rotary"].model_copy(update=change)}})


def driven(rig: Rig, own: Rig, sign: float) -> IdealArm:
    """Planned for `rig`, run on `own`."""
    arm = IdealArm(own, HOME)
    stroke = content("jog", joint="rotary", by=f"{40 * sign} deg", speed="30 deg/s")
    arm.start(plan_run(rig, request(stroke, HOME)), 1700)
    return arm


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_at_the_end_of_the_travel_the_reference_stands_and_so_does_its_rate(rig: Rig, sign: float) -> None:
    end = radians(20.0)
    arm = driven(rig, with_rotary(rig, travel=(-end, end)), sign)
    reference, rate = (sign * np.array(arm.column(name, 0)) for name in ("reference", "reference_rate"))
    standing = reference == end
    assert standing.sum() > 500
    assert reference.max() == end
    assert (rate[standing] == 0.0).all(), "a feed-forward of the planned rate would push on"
    assert rate.max() == pytest.approx(radians(30.0))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_reference_that_lags_has_the_rate_at_which_it_moves(rig: Rig, sign: float) -> None:
    limit = radians(10.0)
    arm = driven(rig, with_rotary(rig, rate_limit=limit), sign)
    reference, rate = (sign * np.array(arm.column(name, 0)) for name in ("reference", "reference_rate"))
    assert rate.max() == pytest.approx(limit)
    assert np.diff(reference)[1000:1200] / PERIOD_S == pytest.approx(rate[1001:1201])
