"""End-point feedback for an arm from data sheets: as much of the reflected tip as the arm's own plant bears, or none.

The link's payload is what the controller knows least. So the plant is linearised at five extensions with payloads from none to more than
the stated one, while the feedback's share follows the link frequency of the stated payload, as it does in the loop.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

from config.schema.end_point import EndPoint
from config.schema.rig import LinkMode, Rig
from servo_control.link.end_point import scheduled_gain
from servo_control.link.link_mode import LinkFrequency
from tuning.linear.closed_loop import Servo, least_damping, sampled_loop
from tuning.linear.family import GAINS
from tuning.linear.linear_arm import LinearArm, linear_arm
from tuning.new_rig.arm import DELAY_PERIODS, OF_LINK_DAMPING, PLACES
from tuning.new_rig.axis import SHARE_OF_GAIN

PAYLOADS = (0.0, 0.5, 1.0, 1.5)  # [A] of the stated one
_STEP = 0.05  # of the gain, from none up: nothing is said of gains above the first that is too much
_STEPS = 40
_Places = list[tuple[LinearArm, float]]  # the arm, and the share that the feedback's schedule leaves there


def tip_feedback(rig: Rig) -> EndPoint | None:
    """The section `end_point` for a rig file with servo, plant and link; None where the feedback would not damp the link. Its gain is
    half of the largest at which every mode of every arm, with 20 % more or less valve gain, keeps half of the link's own damping."""
    link, shape = rig.link_mode, EndPoint()
    assert link is not None
    heard = [place for place in _places(rig, link, shape, (1.0,)) if place[1] > 0.0]
    if not heard:
        return None
    servo = Servo(rig.servo["rotary"].gain, roll_off_Hz=shape.roll_off_Hz)
    gain = SHARE_OF_GAIN * _largest(_places(rig, link, shape, PAYLOADS), servo, rig)
    with_it = replace(servo, tip_gain=min(gain, 1.0))
    better = _least(heard, with_it, rig, (1.0,)) > _least(heard, servo, rig, (1.0,))
    return shape.model_copy(update={"gain": with_it.tip_gain}) if better else None


def _places(rig: Rig, link: LinkMode, shape: EndPoint, payloads: tuple[float, ...]) -> _Places:
    low, high = rig.joints["prismatic"].travel
    believed, whole = LinkFrequency(link), shape.model_copy(update={"gain": 1.0})
    found = []
    for place, payload in product(PLACES, payloads):
        extension_m = low + place * (high - low)
        share = scheduled_gain(whole, believed.frequency_Hz(extension_m))
        found.append((linear_arm(rig, extension_m, payload * link.payload_kg), share))
    return found


def _largest(places: _Places, servo: Servo, rig: Rig) -> float:
    assert rig.link_mode is not None
    kept = OF_LINK_DAMPING * rig.link_mode.damping_ratio
    gains = (_STEP * step for step in range(1, _STEPS + 1))
    borne = 0.0
    for gain in gains:
        if _least(places, replace(servo, tip_gain=gain), rig, GAINS) < kept:
            break
        borne = gain
    return borne


def _least(places: _Places, servo: Servo, rig: Rig, factors: tuple[float, ...]) -> float:
    """Smallest damping ratio of any mode at any place, for every factor on the valve's gain."""
    period_s = 1.0 / rig.loop.rate_Hz
    return min(
        least_damping(
            sampled_loop(arm, replace(servo, gain=factor * servo.gain, tip_gain=share * servo.tip_gain), period_s, DELAY_PERIODS), period_s
        )
        for (arm, share), factor in product(places, factors)
    )
