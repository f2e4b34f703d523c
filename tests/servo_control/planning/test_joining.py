"""A run that begins beside its program: the rest vanishes along a smooth step, over 1 s or as long as a tenth of the rate limit needs."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from config.schema.rig import Rig
from servo_control.planning.motion import Motion
from servo_control.planning.planning import plan_run
from tests.support.servo_control.testbed_runs import INCH, content, request

HOME = [0.0, 30 * INCH]
PERIOD_S = 0.001
STEEPEST = 15 / 8  # of the smooth step of degree five, at its middle


@pytest.mark.parametrize(("offset_rad", "share"), [(radians(12.0), 0.1), (radians(-12.0), 0.1), (radians(0.5), None)])
def test_joining_takes_a_tenth_of_the_rate_limit_but_no_less_than_a_second(rig: Rig, offset_rad: float, share: float | None) -> None:
    joints = rig.joints.values()
    limits = [joint.rate_limit for joint in joints], [joint.acceleration_limit for joint in joints]
    plan = plan_run(rig, request(content("hold", duration=0.1), HOME))
    motion = Motion(plan, [HOME[0] + offset_rad, HOME[1]], *limits, PERIOD_S)
    rates, most = [], 10_000
    while not motion.done and len(rates) < most:
        motion.advance(stop=False)
        rates.append(motion.target_rate[0])
    fastest = share * limits[0][0] if share else STEEPEST * abs(offset_rad) / 1.0
    assert max(np.abs(rates)) == pytest.approx(fastest, rel=1e-5)
    assert len(rates) * PERIOD_S == pytest.approx(STEEPEST * abs(offset_rad) / fastest, abs=3 * PERIOD_S)
    assert motion.target == HOME
    assert sum(rates) * PERIOD_S == pytest.approx(-offset_rad, rel=1e-6)
