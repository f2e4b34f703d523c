"""One hydraulic axis from the numbers of its data sheets, and what follows from them: speeds, force, stiffness, natural frequency, gain.

Steady flow of a valve with equal lands (each K sqrt(dp), K from the rated flow over both lands together) into unequal areas, and the
stiffness of the two oil columns: Merritt, Hydraulic Control Systems, 1967, chapters 5 and 6. SI throughout; for a rotary actuator area
stands for its displacement (m³/rad), mass for inertia, m for rad and N for N m.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi, sqrt

# What data sheets of this size seldom state; each stands in the written file with the tag [A] (assumed) or [C] (typical).
BULK_MODULUS_PA = 1.4e9  # mineral oil under pressure, hoses and a little air counted in
LEAST_DAMPING_RATIO = 0.1  # of the hydraulic resonance without leakage (0.05 to 0.2 is usual)
SEAL_FRICTION = 0.03  # of the largest force
LEAKAGE = 0.002  # of the rated flow at supply pressure
SHARE_OF_GAIN = 0.5  # of the largest velocity gain that the least damping allows: 6 dB of gain margin
SHARE_OF_SPEED = 0.5  # of the slower full speed: the rest is for the servo
SHARE_OF_FORCE = 0.3  # of the largest force for acceleration


@dataclass(frozen=True, slots=True)
class Axis:
    """The numbers asked for. `area_b` equals `area_a` for a rotary actuator or a double-rod cylinder; `dead_volume` is that of each
    chamber with its line."""

    rotary: bool
    area_a: float
    area_b: float
    low: float
    high: float
    mass: float
    dead_volume: float
    rated_flow: float
    rated_drop: float
    full_scale_V: float
    stroke_time_s: float
    supply: float
    resolution: float
    noise: float
    rate_cap: float = inf  # what else limits the joint, as the tip's speed does in an arm
    acceleration_cap: float = inf
    loop_gain_cap_1_s: float = inf

    @property
    def stroke(self) -> float:
        return self.high - self.low

    @property
    def land(self) -> float:
        """K of one land, fully open: m³/s/√Pa."""
        return self.rated_flow / sqrt(0.5 * self.rated_drop)

    @property
    def speeds(self) -> tuple[float, float]:
        """At full opening without load, extending and retracting."""
        ratio = self.area_b / self.area_a
        out = self.land * sqrt(self.supply / (1.0 + ratio**3)) / self.area_a
        return out, out * sqrt(ratio)

    @property
    def force(self) -> float:
        """Largest in the weaker direction."""
        return self.supply * self.area_b

    @property
    def natural_frequency_rad_s(self) -> float:
        """Of mass on oil, where the oil is softest along the stroke."""
        return sqrt(min(self._stiffness(k / 100) for k in range(101)) / self.mass)

    def _stiffness(self, share: float) -> float:
        a = self.dead_volume + self.area_a * share * self.stroke
        b = self.dead_volume + self.area_b * (1.0 - share) * self.stroke
        return BULK_MODULUS_PA * (self.area_a**2 / a + self.area_b**2 / b)

    @property
    def velocity_gain(self) -> float:
        """Speed per volt, of the faster direction: the one that decides stability."""
        return max(self.speeds) / self.full_scale_V

    @property
    def loop_gain_1_s(self) -> float:
        """Velocity constant of the position loop. K_v = 2 ζ ω_h is the stability limit of an integrator beside the hydraulic resonance
        (Merritt §6.5); the valve's own corner costs phase too."""
        resonance = 2.0 * LEAST_DAMPING_RATIO * self.natural_frequency_rad_s
        valve = 1.0 / (2.0 * self.stroke_time_s)
        return min(SHARE_OF_GAIN * min(resonance, valve), self.loop_gain_cap_1_s)

    @property
    def gain(self) -> float:
        """Servo gain in V per m or rad."""
        return self.loop_gain_1_s / self.velocity_gain

    @property
    def rate_limit(self) -> float:
        return min(SHARE_OF_SPEED * min(self.speeds), self.rate_cap)

    @property
    def acceleration_limit(self) -> float:
        """What the force allows, and no more than reaches the rate limit within four periods of the resonance."""
        slow_enough = self.rate_limit * self.natural_frequency_rad_s / (4 * 2 * pi)
        return min(SHARE_OF_FORCE * self.force / self.mass, slow_enough, self.acceleration_cap)

    @property
    def friction(self) -> float:
        return SEAL_FRICTION * self.force

    @property
    def viscous(self) -> float:
        """As much as the seals' friction at the rate limit."""
        return self.friction / self.rate_limit

    @property
    def leakage(self) -> float:
        """Across the piston, m³/s/Pa."""
        return LEAKAGE * self.rated_flow / self.supply

    @property
    def bristle_stiffness(self) -> float:
        """Friction yields over a twenty-thousandth of the stroke before it slides."""
        return self.friction / (self.stroke / 20_000)

    @property
    def bristle_damping(self) -> float:
        return 2 * 0.3 * sqrt(self.bristle_stiffness * self.mass)
