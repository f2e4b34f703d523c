"""ISO VG grades of hydraulic oil (ISO 3448: the number is the viscosity at 40 degC in cSt) as constants of Walther's law."""

from __future__ import annotations

from math import log10

KELVIN = 273.15
# Grade → viscosity in cSt at 100 degC of an oil of viscosity index 100, by ASTM D2270.
GRADES = {10: 2.66, 15: 3.41, 22: 4.29, 32: 5.36, 46: 6.76, 68: 8.73, 100: 11.38, 150: 15.02}


def walther_constants(at_40C_cSt: float, at_100C_cSt: float) -> tuple[float, float]:
    """A and B of log10 log10(nu + 0.7) = A - B log10 T through two viscosities (ASTM D341)."""
    low, high = (log10(log10(nu + 0.7)) for nu in (at_40C_cSt, at_100C_cSt))
    slope = (low - high) / (log10(100 + KELVIN) - log10(40 + KELVIN))
    return low + slope * log10(40 + KELVIN), slope
