"""First frequency of the clamped link over its extension, one static shape, (P29) of docs/method/plant.md:

    ω_n(L) = √(3 EI / (L³ (M_p + 33/140 m L))),   ω_d = ω_n √(1 − ζ²)

At most 0.02 % high with 15 lb or more at the tip of the testbed's tube, 1.5 % high without payload.
"""

from __future__ import annotations

from math import pi, sqrt

from config.schema.rig import LinkMode
from servo_control.numerics.table import between


class LinkFrequency:
    """What the controller believes about the link. `scale` multiplies every frequency (to study a wrong belief).

    Where `link.frequency_map` has measured frequencies, the formula is multiplied by measured over computed: on straight lines between
    the points, constant beyond them.
    """

    __slots__ = ("_added", "_extensions", "_factor", "_mass", "_ratios", "damping_ratio")

    def __init__(self, link: LinkMode, scale: float = 1.0) -> None:
        self.damping_ratio = link.damping_ratio
        self._factor = 3.0 * link.bending_stiffness_N_m2 * (1.0 - link.damping_ratio**2) * scale**2
        self._mass = link.payload_kg
        self._added = 33.0 / 140.0 * link.mass_per_length_kg_per_m
        self._extensions = [point.extension_m for point in link.frequency_map]
        self._ratios = [scale * 2.0 * pi * point.frequency_Hz / self._formula(point.extension_m) for point in link.frequency_map]

    def omega_d(self, extension_m: float) -> float:
        """Damped angular frequency in rad/s at an extension > 0."""
        return self._formula(extension_m) * self._ratio(extension_m) if self._ratios else self._formula(extension_m)

    def _formula(self, extension_m: float) -> float:
        return sqrt(self._factor / (extension_m**3 * (self._mass + self._added * extension_m)))

    def _ratio(self, extension_m: float) -> float:
        below, above, share = between(self._extensions, extension_m)
        return self._ratios[below] + share * (self._ratios[above] - self._ratios[below])

    def frequency_Hz(self, extension_m: float) -> float:
        """Damped frequency in Hz."""
        return self.omega_d(extension_m) / (2.0 * pi)
