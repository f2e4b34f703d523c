"""What the shapers are for: vibration left in the holds of the paper's line, joints ideal, 45 lb, judged by link_model.

Reference figures: independent two-shape simulation published with the design (acceptance rows 20 to 22, table 7.3).
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from config.schema.rig import Rig
from servo_control.planning.planning import plan_run
from servo_control.planning.prediction import predict
from tests.support.servo_control.link_model import frequency_Hz, hold_amplitudes, largest_line, tip_acceleration, tip_motion
from tests.support.servo_control.testbed_runs import request, shipped

PROGRAM_SAMPLES = 18_300
Judged = tuple[tuple[float, ...], float, float]  # hold amplitudes m/s², largest spectral line, largest deflection m
_rigs: list[Rig] = []


@pytest.fixture(autouse=True)
def _keep_rig(rig: Rig) -> None:
    _rigs[:] = [rig]


@cache
def _judged(maneuver: str, shaper: tuple[tuple[str, Any], ...]) -> Judged:
    plan = plan_run(_rigs[0], request(shipped(maneuver), shaper=dict(shaper)))
    rows = np.array([(*cycle.reference, *cycle.reference_rate) for cycle in predict(_rigs[0], plan)])
    theta, length, theta_rate, length_rate = rows.T
    w, w_rate = tip_motion(theta, theta_rate, length, length_rate)
    acceleration = tip_acceleration(w, w_rate, theta_rate, length, length_rate)
    return tuple(hold_amplitudes(w, w_rate, length)), largest_line(acceleration[:PROGRAM_SAMPLES]), float(np.abs(w).max())


def _reductions_dB(maneuver: str, **shaper: Any) -> np.ndarray:
    shaped = np.array(_judged(maneuver, tuple(shaper.items()))[0])
    return 20 * np.log10(shaped / np.array(_judged(maneuver, (("kind", "none"),))[0]))


def _rms_dB(maneuver: str, **shaper: Any) -> float:
    shaped = np.array(_judged(maneuver, tuple(shaper.items()))[0])
    return float(10 * np.log10((shaped**2).sum() / (np.array(_judged(maneuver, (("kind", "none"),))[0]) ** 2).sum()))


def _spectrum_dB(maneuver: str, **shaper: Any) -> float:
    return float(20 * np.log10(_judged(maneuver, tuple(shaper.items()))[1] / _judged(maneuver, (("kind", "none"),))[1]))


@pytest.mark.slow
def test_unfiltered_line_leaves_the_known_vibration() -> None:
    """Row 20: 4.09 / 3.00 / 9.35 m/s² at 3.20 / 3.20 / 5.41 Hz; deflection up to 11.6 mm."""
    amplitudes, _, deflection = _judged("paper_line_y30", (("kind", "none"),))
    assert amplitudes == pytest.approx((4.09, 3.00, 9.35), rel=0.05)
    assert deflection == pytest.approx(0.0116, rel=0.05)
    inch = 0.0254
    assert (frequency_Hz(np.hypot(30, 30) * inch), frequency_Hz(30 * inch)) == pytest.approx((3.20, 5.41), abs=0.01)


@pytest.mark.slow
def test_phase_domain_shaper_takes_40_dB_off_every_hold() -> None:
    """Row 22, first half."""
    assert (_reductions_dB("paper_line_y30", kind="adaptive") <= -40.0).all()


@pytest.mark.slow
@pytest.mark.parametrize("scale", [0.9, 1.1])
def test_phase_domain_shaper_forgives_ten_percent_of_frequency(scale: float) -> None:
    """Row 22, second half."""
    assert _rms_dB("paper_line_y30", kind="adaptive", frequency_scale=scale) <= -28.0


@pytest.mark.slow
@pytest.mark.parametrize("y", ["paper_line_y30", "paper_line"])
def test_shaping_both_joints_is_no_worse(y: str) -> None:
    assert (_reductions_dB(y, kind="adaptive", joints=("rotary", "prismatic")) <= -40.0).all()


@pytest.mark.slow
@pytest.mark.parametrize(("focal", "expected_dB"), [("initial", -17.8), ("final", -19.5)])
def test_fixed_three_term_gives_the_papers_20_dB(focal: str, expected_dB: float) -> None:
    """Row 21, y0 = 40 in, largest line of the spectrum."""
    assert _spectrum_dB("paper_line", kind="three_term", focal=focal) == pytest.approx(expected_dB, abs=2.0)


TABLE = [
    ("paper_line_y30", {"kind": "zv", "focal": "initial"}, (-7.7, -5.6, -9.4)),
    ("paper_line_y30", {"kind": "three_term", "focal": "initial"}, (-11.9, -9.7, -14.1)),
    ("paper_line_y30", {"kind": "zvd", "focal": "final"}, (-11.8, -19.0, -8.7)),
    ("paper_line_y30", {"kind": "three_term", "focal": "mid"}, (-20.8, -17.6, -17.0)),
    ("paper_line_y30", {"kind": "ei", "focal": "mid"}, (-23.4, -20.4, -19.6)),
    ("paper_line_y30", {"kind": "two_hump_ei", "focal": "mid"}, (-28.2, -25.9, -29.0)),
    ("paper_line_y30", {"kind": "notch", "focal": "final"}, (-14.0, -22.2, -10.1)),
    ("paper_line_y30", {"kind": "robust_notch", "focal": "mid"}, (-22.0, -19.1, -21.0)),
    ("paper_line_y30", {"kind": "adaptive_delay"}, (-30.1, -24.5, -30.3)),
    ("paper_line", {"kind": "three_term", "focal": "mid"}, (-29.4, -23.9, -24.6)),
    ("paper_line", {"kind": "robust_notch", "focal": "mid"}, (-33.3, -29.6, -31.0)),
    ("paper_line", {"kind": "adaptive_delay"}, (-30.6, -32.0, -49.2)),
]


@pytest.mark.slow
@pytest.mark.parametrize(("y", "shaper", "expected_dB"), TABLE)
def test_table_of_residual_vibration(y: str, shaper: dict[str, Any], expected_dB: tuple[float, ...]) -> None:
    """Table 7.3, ideal joints, rotary command filtered only; 0.5 dB."""
    assert _reductions_dB(y, **shaper) == pytest.approx(np.array(expected_dB), abs=0.5)


@pytest.mark.slow
@pytest.mark.parametrize(("y", "rms_dB"), [("paper_line_y30", -43.8), ("paper_line", -41.1)])
def test_scheduled_coefficients(y: str, rms_dB: float) -> None:
    assert _rms_dB(y, kind="adaptive_coefficients", delay_s=0.1) == pytest.approx(rms_dB, abs=1.0)
