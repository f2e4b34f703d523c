"""The largest friction gain that the end-point feedback tolerates: damping of the arm while friction holds its joint, for every payload.

A joint at rest is elastic (bristles and oil). The push against friction (`end_point.friction_gain`) drives the arm through this spring.
Where the payload is far from the believed one, too much of it makes the link oscillate though the joint never breaks loose. Positive
damping of every mode of that arm excludes it (docs/decisions/motion/0009).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

from config.schema.end_point import EndPoint
from config.schema.rig import Rig
from servo_control.link.end_point import lead_shares, scheduled_gain
from servo_control.link.link_mode import LinkFrequency
from servo_control.servo.oil_compensation import OilCompensation
from tuning.linear.closed_loop import Servo, least_damping, sampled_loop
from tuning.linear.family import GAINS
from tuning.linear.linear_arm import LinearArm, linear_arm
from tuning.loop_design.workspace import OVERLOAD, places_in
from tuning.variants import ROTARY

EXTENSIONS = 17  # evenly over the travel
PAYLOAD_SHARES = (0.0, 3 / 45, 5 / 45, 10 / 45, 20 / 45, OVERLOAD)  # of the believed payload
OIL_C = (20.0, 40.0, 60.0)
STEEPEST = 500.0  # s/rad
HALVINGS = 10


@dataclass(frozen=True, slots=True)
class StuckPlace:
    """The arm somewhere, and what the controller believes of it: share of the tip gain, its lead, link in rad/s, friction in V."""

    arm: LinearArm
    tip_share: float
    tip_lead: tuple[float, float]
    omega: float
    friction_V: float


def stuck_places(rig: Rig) -> list[StuckPlace]:
    """Everywhere in the workspace; the rig needs plant and link_mode. None without an oil table of the rotary joint."""
    servo, period_s = rig.servo[ROTARY], 1.0 / rig.loop.rate_Hz
    if rig.link_mode is None or servo.oil_compensation is None:
        return []
    link, settings = LinkFrequency(rig.link_mode), (rig.end_point or EndPoint()).model_copy(update={"gain": 1.0})
    found = []
    shares = product((k / (EXTENSIONS - 1) for k in range(EXTENSIONS)), PAYLOAD_SHARES)
    for (extension, payload_kg), oil_C in product(places_in(rig, shares), OIL_C):
        frequency_Hz = link.frequency_Hz(extension)
        share, lead = scheduled_gain(settings, frequency_Hz), lead_shares(settings, frequency_Hz)
        arm = linear_arm(rig, extension, payload_kg, oil_C, stuck=True)
        oil = OilCompensation(servo.oil_compensation, servo.velocity_feedforward, period_s)
        oil.measure(oil_C)
        found.append(StuckPlace(arm, share, lead, link.omega_d(extension), oil.friction_V))
    return found


def stuck_damping(places: list[StuckPlace], period_s: float, servo: Servo, friction_gain: float) -> float:
    """Smallest damping ratio of any mode at any place and the family's largest gain; `friction_gain` in s/rad."""
    gain = max(GAINS)
    return min(least_damping(sampled_loop(place.arm, _at(place, servo, gain, friction_gain), period_s), period_s) for place in places)


def largest_friction_gain(rig: Rig, servo: Servo) -> float:
    """The largest `end_point.friction_gain` (s/rad) that leaves every mode damped with this servo; 0 where none does."""
    places, period_s = stuck_places(rig), 1.0 / rig.loop.rate_Hz
    low, high = 0.0, STEEPEST
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if stuck_damping(places, period_s, servo, middle) > 0.0:
            low = middle
        else:
            high = middle
    return low


def _at(place: StuckPlace, servo: Servo, gain: float, friction_gain: float) -> Servo:
    push = gain * friction_gain * place.omega * place.friction_V
    return replace(servo, gain=gain * servo.gain, tip_gain=servo.tip_gain * place.tip_share, tip_lead=place.tip_lead, push=push)
