"""The controlled stop of a fast joint is as hard as its acceleration limit allows and no harder, in both directions."""

from __future__ import annotations

import numpy as np
import pytest

from config.schema.rig import Rig
from servo_control.planning.planning import plan_run
from servo_control.signals import Mode
from tests.support.servo_control.ideal_arm import PERIOD_S, IdealArm
from tests.support.servo_control.testbed_runs import INCH, content, request

# From its rate limit a joint needs 0.1 s (rotary) or 0.09 s (prismatic) at its acceleration limit: longer than the 1/20 s of a slow one.
STROKES = {
    "rotary up": ("rotary", "80 deg", [np.radians(-40.0), 36 * INCH]),
    "rotary down": ("rotary", "-80 deg", [np.radians(40.0), 36 * INCH]),
    "prismatic out": ("prismatic", "40 in", [0.0, 16 * INCH]),
    "prismatic in": ("prismatic", "-40 in", [0.0, 56 * INCH]),
}
# Share of the stroke, and slack: where the rate changes by itself (a jog takes a fifth of the limit) one cycle's arithmetic, which takes
# σ² for the mean of σ over the cycle, is off by 1.5 · 0.2 · 20/s · T of the limit at most.
MOMENTS = {"speeding up": (0.14, 0.006), "at the rate limit": (0.5, 1e-9), "slowing down": (0.86, 0.006)}


@pytest.mark.parametrize(("share", "slack"), MOMENTS.values(), ids=MOMENTS)
@pytest.mark.parametrize(("name", "by", "start"), STROKES.values(), ids=STROKES)
def test_a_stop_uses_the_acceleration_limit_and_keeps_it(
    rig: Rig, name: str, by: str, start: list[float], share: float, slack: float
) -> None:
    limits, joint, arm = rig.joints[name], list(rig.joints).index(name), IdealArm(rig, start)
    speed = f"{limits.rate_limit} {'rad/s' if name == 'rotary' else 'm/s'}"
    plan = plan_run(rig, request(content("jog", joint=name, by=by, speed=speed), start))
    arm.start(plan, round(share * plan.duration_s / PERIOD_S))
    begin = len(arm.log)
    arm.until(Mode.STOPPING, 1, lambda out: out.stopped, most=400)
    change = abs(np.diff(arm.column("target_rate", joint)[begin - 1 :]))
    largest = limits.acceleration_limit * PERIOD_S
    assert 0.95 * largest <= change.max() <= largest * (1 + slack)
    assert arm.log[-1].joints[joint].target_rate == 0.0
