"""A turning joint that carries a sliding tube with a payload, from data sheets: what the link makes of the two axes.

Inertia about the hub J = J_hub + m_p L² + m' L³/3 with the tube of mass m' a length extended by L; a steel or aluminium tube bends with
EI = E π (D⁴ − d⁴)/64. The rotary servo's gain comes from the written plant itself, linearised with its flexible link.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi

from config.schema.rig import Rig
from tuning.linear.closed_loop import Servo, least_damping, sampled_loop
from tuning.linear.linear_arm import LinearArm, linear_arm
from tuning.new_rig.axis import SHARE_OF_GAIN, Axis

MATERIALS = {"steel": (200e9, 7850.0), "aluminium": (70e9, 2700.0)}  # Young's modulus (Pa), density (kg/m³)
TIP_SPEED_M_PER_S = 1.0  # [A] at the longest extension
TIP_ACCELERATION_M_PER_S2 = 5.0  # [A] there too
OF_LINK_DAMPING = 0.5  # of the tube's own damping that the servo leaves every mode
DAMPING_RATIO = 0.005  # [A] of the tube by itself
PLACES = (0.0, 0.25, 0.5, 0.75, 1.0)  # of the extension's range
_BISECTIONS = 12
DELAY_PERIODS = 1  # a real valve's command acts one period later


@dataclass(frozen=True, slots=True)
class Tube:
    """The link (SI): `total_length` with what stays in its bearing; `carriage` slides with it."""

    outside: float
    inside: float
    total_length: float
    material: str
    hub_inertia: float
    carriage: float
    payload: float

    @property
    def mass_per_length(self) -> float:
        return MATERIALS[self.material][1] * pi / 4 * (self.outside**2 - self.inside**2)

    @property
    def bending_stiffness(self) -> float:
        return MATERIALS[self.material][0] * pi / 64 * (self.outside**4 - self.inside**4)

    @property
    def sliding_mass(self) -> float:
        return self.carriage + self.payload + self.mass_per_length * self.total_length

    def inertia(self, extension: float) -> float:
        """About the hub, with the payload."""
        return self.hub_inertia + self.payload * extension**2 + self.mass_per_length * extension**3 / 3


def with_tip_limits(rotary: Axis, longest: float) -> Axis:
    """No faster than the tip may be at the longest extension."""
    return replace(rotary, rate_cap=TIP_SPEED_M_PER_S / longest, acceleration_cap=TIP_ACCELERATION_M_PER_S2 / longest)


def with_stable_gain(rotary: Axis, rig: Rig) -> Axis:
    """The rotary axis with half the loop gain at which its own plant, `rig`, would lose half of the link's damping somewhere: at five
    extensions, with and without the payload, the loop sampled and one period late."""
    link = rig.link_mode
    assert link is not None
    travel, period_s = rig.joints["prismatic"].travel, 1 / rig.loop.rate_Hz
    extensions = [travel[0] + share * (travel[1] - travel[0]) for share in PLACES]
    arms = [linear_arm(rig, extension, payload) for extension in extensions for payload in (0.0, link.payload_kg)]
    low, high = 0.0, rotary.gain / SHARE_OF_GAIN
    if _least(arms, high, period_s) >= OF_LINK_DAMPING * link.damping_ratio:
        return rotary
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _least(arms, middle, period_s) >= OF_LINK_DAMPING * link.damping_ratio else (low, middle)
    return replace(rotary, loop_gain_cap_1_s=SHARE_OF_GAIN * low * rotary.velocity_gain)


def _least(arms: list[LinearArm], gain: float, period_s: float) -> float:
    """Smallest damping ratio of any mode of any arm under a servo gain (V/rad)."""
    return min(least_damping(sampled_loop(arm, Servo(gain), period_s, DELAY_PERIODS), period_s) for arm in arms)
