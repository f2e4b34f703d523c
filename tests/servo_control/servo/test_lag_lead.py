"""Compensator against printed designs, scipy's bilinear transform, and what anti-windup promises."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from servo_control.servo.lag_lead import LagLead

PERIOD_S = 0.001
# Lag-lead designs A, B, C of the reference: DC gain, ((lead zero, pole), (lag zero, pole)), printed b and a at 1 kHz.
DESIGNS = {
    "A": ((0.02447952, 1.65439724, 11.66848887), (0.00167833, 1.00223778, 1.33333333),
          [11.611065458806, -22.457805369765, 10.852092955564], [1, -1.539600973020, 0.540212654009]),
    "B": ((0.01295869, 0.81945899, 5.72631543), (0.00181041, 1.00241387, 1.33333333),
          [5.782943994174, -11.208965631296, 5.428498474748], [1, -1.565843188267, 0.566419902946]),
    "C": ((0.00921344, 0.47949064, 3.24626488), (0.00227053, 1.00302738, 1.33333333),
          [3.410065168793, -6.646006721694, 3.237112483434], [1, -1.637726227622, 0.638207162102]),
}  # fmt: skip
CORNERS = {"A": ((59.58, 595.8), (8.0, 4 / 3)), "B": ((55.24, 552.4), (8.0, 4 / 3)), "C": ((44.04, 440.4), (8.0, 4 / 3))}
K = {"A": 1.4586, "B": 0.7158, "C": 0.4058}


def _impulse_response(compensator: LagLead, samples: int) -> np.ndarray:
    return np.array([compensator.step(1.0 if n == 0 else 0.0) for n in range(samples)])


@pytest.mark.parametrize("name", DESIGNS)
def test_printed_coefficients(name: str) -> None:
    """The zeros and poles of the printed discrete designs give the printed impulse response to 1e-9.

    The corners are recovered from the printed discrete polynomials by the inverse Tustin rule, so nothing is lost in rounding.
    """
    b, a = DESIGNS[name][2:]
    corners_of = lambda roots: np.sort([2 / PERIOD_S * (1 - r) / (1 + r) for r in np.roots(roots)])  # noqa: E731
    zeros, poles = corners_of(b), corners_of(a)
    compensator = LagLead(sum(b) / sum(a), [(zeros[1], poles[1]), (zeros[0], poles[0])], PERIOD_S)
    expected = signal.lfilter(b, a, np.eye(1, 400)[0])
    assert _impulse_response(compensator, 400) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("name", DESIGNS)
def test_printed_corners_give_the_printed_design(name: str) -> None:
    """The corners of the table, printed to four digits, against the printed coefficients: to the rounding of the table."""
    lead, lag = CORNERS[name]
    compensator = LagLead(K[name] * lag[0] / lag[1], [lead, lag], PERIOD_S)
    expected = signal.lfilter(*DESIGNS[name][2:], np.eye(1, 100)[0])
    assert _impulse_response(compensator, 100) == pytest.approx(expected, abs=2e-3 * max(abs(expected)))


@pytest.mark.parametrize("name", DESIGNS)
def test_frequency_response_is_the_bilinear_transform_of_the_continuous_design(name: str) -> None:
    lead, lag = CORNERS[name]
    gain = K[name] * lag[0] / lag[1]
    numerator = gain * np.polymul([1 / lead[0], 1], [1 / lag[0], 1])
    denominator = np.polymul([1 / lead[1], 1], [1 / lag[1], 1])
    b, a = signal.bilinear(numerator, denominator, 1 / PERIOD_S)
    w, expected = signal.freqz(b, a, 200)
    impulse = _impulse_response(LagLead(gain, [lead, lag], PERIOD_S), 20_000)  # the lag pole has decayed to 3e-12
    assert np.exp(-1j * np.outer(w, np.arange(20_000))) @ impulse == pytest.approx(expected, abs=1e-8 * abs(expected).max())


@pytest.mark.parametrize("corners", [[(8.0, 4 / 3)], [(44.04, 440.4), (8.0, 4 / 3)], [(8.0, 4 / 3), (44.04, 440.4)]])
def test_preload_is_bumpless(corners: list[tuple[float, float]]) -> None:
    compensator = LagLead(140.0, corners, PERIOD_S)
    compensator.preload(0.002, -0.7)
    outputs = [compensator.step(0.002) for _ in range(8000)]
    assert outputs[0] == pytest.approx(-0.7, abs=1e-12)
    assert max(abs(np.diff(outputs))) < 0.05
    assert outputs[-1] == pytest.approx(140.0 * 0.002, abs=1e-4)


def test_anti_windup_leaves_the_limit_at_once() -> None:
    """Ten seconds against the limit, then no error: the command leaves the limit at once; without conditioning it stays there."""
    compensator, plain = LagLead(2.43, CORNERS["C"], PERIOD_S), LagLead(2.43, CORNERS["C"], PERIOD_S)
    for _ in range(10_000):
        wanted = compensator.step(5.0)
        if wanted > 5.0:
            compensator.condition(5.0, 5.0 - wanted)
        plain.step(5.0)
    conditioned_V = [compensator.step(0.0) for _ in range(400)]
    plain_V = [plain.step(0.0) for _ in range(400)]
    assert max(conditioned_V) < 5.0
    assert plain_V[-1] > 5.0


def test_conditioned_states_reproduce_the_limited_command() -> None:
    """After conditioning the compensator is where the error that gives the limited command would have brought it."""
    corners = CORNERS["C"]
    conditioned, reference = LagLead(2.43, corners, PERIOD_S), LagLead(2.43, corners, PERIOD_S)
    limited = 5.0
    wanted = conditioned.step(4.0)
    conditioned.condition(4.0, limited - wanted)
    assert reference.step(4.0 * limited / wanted) == pytest.approx(limited, rel=1e-12)  # from rest the output is proportional
    assert conditioned.snapshot() == pytest.approx(reference.snapshot(), rel=1e-12)
