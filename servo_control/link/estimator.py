"""Tip deflection from the tip accelerometer: a Kalman filter on the link's first mode, for rigs without a deflection sensor:
(C6) of docs/method/control.md.

State (w, v) and its motion: see `servo_control.link.link_motion`. Measured is

    y = −ω² w − 2ζω (v − α θ̇) + b

y is the accelerometer, b its bias. w is seen through the link's stiffness, not by integrating twice, so the bias cannot make it drift.
Left out of y: (L − α) θ̈, 0.4 % of L θ̈ with 45 lb.
"""

from __future__ import annotations

from math import cos, isfinite, sin
from typing import Any

from config.schema.end_point import EndPoint
from config.schema.rig import LinkMode
from servo_control.link.link_mode import LinkFrequency
from servo_control.link.link_motion import carried_arm, one_period

START_VARIANCE = (1e-6, 1e-4, 0.01)  # m², m²/s², (m/s²)²: 1 mm, 1 cm/s and 10 mg
# What the model does not know, as spectral densities: 0.3 m/s² in 100 Hz of unknown acceleration, and a bias that wanders 1 mg in a minute.
ACCELERATION_DENSITY = 1e-3
BIAS_DENSITY = 1.6e-6


class TipEstimator:
    """State (w, v, b) and its covariance, all plain floats. `step` gives the deflection in m."""

    __slots__ = ("_frequency", "_link", "_noise", "_p", "_period_s", "_x")

    def __init__(self, settings: EndPoint, link: LinkMode, period_s: float) -> None:
        self._frequency = LinkFrequency(link)
        self._link = link
        self._period_s = period_s
        self._noise = settings.acceleration_noise_m_per_s2**2
        self._x = [0.0, 0.0, 0.0]
        self._p = [0.0] * 6
        self.reset()

    def reset(self) -> None:
        """Straight link, unknown bias."""
        self._x = [0.0, 0.0, 0.0]
        w, v, b = START_VARIANCE
        self._p = [w, 0.0, 0.0, v, 0.0, b]  # upper triangle by rows: ww, wv, wb, vv, vb, bb

    def step(self, acceleration: float, length: float, length_rate: float, rotary_rate: float) -> float:
        """Correct with this cycle's sample (m/s²; NaN: lost, predict only), then predict to the next; returns w (m) at the sample."""
        omega = self._frequency.omega_d(length)
        drag = 2.0 * self._link.damping_ratio * omega
        arm = carried_arm(self._link, length)
        if isfinite(acceleration):
            self._correct(acceleration - drag * arm * rotary_rate, -omega * omega, -drag)
        w = self._x[0]
        if not isfinite(w):  # a broken sample of a position or rate: begin again
            self.reset()
            return 0.0
        self._predict(omega, drag, arm * rotary_rate, length_rate * rotary_rate)
        return w

    def _correct(self, y: float, h_w: float, h_v: float) -> None:
        """Kalman update with y = h_w w + h_v v + b."""
        x, (ww, wv, wb, vv, vb, bb) = self._x, self._p
        g_w, g_v, g_b = h_w * ww + h_v * wv + wb, h_w * wv + h_v * vv + vb, h_w * wb + h_v * vb + bb
        inverse = 1.0 / (h_w * g_w + h_v * g_v + g_b + self._noise)
        k_w, k_v, k_b = g_w * inverse, g_v * inverse, g_b * inverse
        miss = y - h_w * x[0] - h_v * x[1] - x[2]
        x[0] += k_w * miss
        x[1] += k_v * miss
        x[2] += k_b * miss
        self._p = [ww - k_w * g_w, wv - k_w * g_v, wb - k_w * g_b, vv - k_v * g_v, vb - k_v * g_b, bb - k_b * g_b]

    def _predict(self, omega: float, drag: float, carried: float, swept: float) -> None:
        """One period: exact rotation of the oscillator about its moving equilibrium, damping and inputs to first order."""
        t = self._period_s
        c, s = cos(omega * t), sin(omega * t)
        a, b, d = c, s / omega, -omega * s
        keep = 1.0 - drag * t
        w, v = one_period((self._x[0], self._x[1]), omega, drag, carried, swept, t)
        self._x = [w, v, self._x[2]]
        ww, wv, wb, vv, vb, bb = self._p
        d, c = d * keep, c * keep
        q = ACCELERATION_DENSITY * t
        self._p = [
            a * a * ww + 2.0 * a * b * wv + b * b * vv,
            a * d * ww + (a * c + b * d) * wv + b * c * vv,
            a * wb + b * vb,
            d * d * ww + 2.0 * d * c * wv + c * c * vv + q,
            d * wb + c * vb,
            bb + BIAS_DENSITY * t,
        ]

    def snapshot(self) -> dict[str, Any]:
        return {"x": list(self._x), "p": list(self._p)}

    def restore(self, state: dict[str, Any]) -> None:
        self._x, self._p = list(state["x"]), list(state["p"])
