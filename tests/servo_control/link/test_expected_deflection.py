"""The deflection that a reference motion causes: against the mode's equation of motion solved by another integrator, and its fading."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from config.schema.rig import LinkMode
from servo_control.link.expected_deflection import FADE_S, ExpectedDeflection
from servo_control.link.link_mode import LinkFrequency
from servo_control.link.link_motion import carried_arm

PERIOD_S = 0.001
LINK = LinkMode(bending_stiffness=3556.75, mass_per_length=2.545698, payload=20.41, damping_ratio=0.005)


def _length(t: float) -> tuple[float, float]:
    """Extension and its rate, 1.0 to 1.2 m."""
    return 1.1 - 0.1 * cos(1.3 * t), 0.13 * sin(1.3 * t)


def _rate(t: float) -> tuple[float, float]:
    """Joint rate and acceleration."""
    return 0.05 + 0.2 * sin(3.0 * t) ** 2, 1.2 * sin(3.0 * t) * cos(3.0 * t)


def _mode(t: float, state: list[float]) -> list[float]:
    """ẅ = −ω² w − 2ζω ẇ − α θ̈ − (L̇ + α̇) θ̇, α̇ = L̇ dα/dL: the mode's own equation, with the joint's acceleration."""
    (length, length_rate), (rate, acceleration) = _length(t), _rate(t)
    omega = LinkFrequency(LINK).omega_d(length)
    arm_rate = (carried_arm(LINK, length + 1e-6) - carried_arm(LINK, length - 1e-6)) / 2e-6 * length_rate
    forced = -carried_arm(LINK, length) * acceleration - (length_rate + arm_rate) * rate
    return [state[1], -omega * omega * state[0] - 2 * LINK.damping_ratio * omega * state[1] + forced]


def test_against_the_equation_of_motion() -> None:
    times = np.arange(0.0, 3.0, PERIOD_S)
    expected = ExpectedDeflection(LINK, PERIOD_S)
    ours = []
    for t in times:
        (length, length_rate), (rate, _) = _length(t), _rate(t + 0.5 * PERIOD_S)  # the rate in the middle of the period
        ours.append(expected.step(length, length_rate, rate))
    start = [0.0, -carried_arm(LINK, _length(0.0)[0]) * _rate(0.0)[0]]
    solution = solve_ivp(_mode, (0.0, 3.1), start, t_eval=times + PERIOD_S, rtol=1e-8, atol=1e-10)
    assert np.abs(solution.y[0]).max() > 0.002
    assert np.array(ours) == pytest.approx(solution.y[0], abs=4e-5)


def test_nothing_is_expected_of_a_reference_at_rest() -> None:
    """After a jerk of the joint the model would ring for minutes; with the reference at rest it is gone in half a second."""
    expected = ExpectedDeflection(LINK, PERIOD_S)
    moving = [expected.step(1.1, 0.0, 0.3) for _ in range(150)]
    assert max(map(abs, moving)) > 0.01
    resting = [expected.step(1.1, 0.0, 0.0) for _ in range(500)]
    assert abs(resting[-1]) < 0.02 * np.exp(-0.4 / FADE_S) * 2
    assert max(abs(np.diff([moving[-1], *resting]))) < max(abs(np.diff(moving))) + 1.5 * PERIOD_S / FADE_S * max(map(abs, moving))


def test_alpha_is_the_extension_for_a_heavy_payload() -> None:
    heavy = LINK.model_copy(update={"payload_kg": 1e6})
    assert carried_arm(heavy, 1.2) == pytest.approx(1.2, rel=1e-6)
    assert carried_arm(LINK.model_copy(update={"payload_kg": 0.0}), 1.2) == pytest.approx(1.2 * 11 / 40 / (33 / 140))


def test_quasi_static_limit() -> None:
    """A slow joint motion bends the link by −α θ̈/ω²."""
    expected = ExpectedDeflection(LINK, PERIOD_S)
    omega, slow = LinkFrequency(LINK).omega_d(0.6), 2 * pi * 0.3
    w = [expected.step(0.6, 0.0, 0.2 * (1 - cos(slow * n * PERIOD_S))) for n in range(8000)]
    acceleration = [0.2 * slow * sin(slow * n * PERIOD_S) for n in range(8000)]
    late = slice(2000, None)
    gain = np.dot(w[late], acceleration[late]) / np.dot(acceleration[late], acceleration[late])
    assert gain == pytest.approx(-carried_arm(LINK, 0.6) / omega**2, rel=0.02)
