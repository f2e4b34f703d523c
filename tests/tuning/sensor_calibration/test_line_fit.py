"""A sensor's line from points: against the closed form, and refused with reasons where points, noise or residual forbid it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.stats import norm, t

from config.errors import ConfigError
from tuning.sensor_calibration.line_fit import Limits, ReferencePoint, calibrated

WHERE = "signals.axis.position"
METRES = ("m", 1.0, 0.0)


@given(
    scale=st.floats(1e-6, 1e-2) | st.floats(-1e-2, -1e-6),
    offset=st.floats(-10, 10),
    counts=st.lists(st.integers(0, 2**32 - 1), min_size=2, max_size=6, unique=True),
)
def test_a_straight_sensor_gets_its_own_sign_scale_and_zero(scale: float, offset: float, counts: list[int]) -> None:
    assume(max(counts) - min(counts) >= 1000)
    found = calibrated([ReferencePoint(offset + scale * count, count) for count in counts], Limits(), METRES, WHERE, "watch")
    np.testing.assert_allclose(found.scale, scale, rtol=1e-6)
    span = abs(scale) * (max(counts) - min(counts))
    readings = [found.offset + found.scale * count for count in counts]
    np.testing.assert_allclose(readings, [offset + scale * count for count in counts], atol=1e-6 * span + 1e-9 * abs(scale) * 2**32)


def test_the_line_is_the_textbooks() -> None:
    """Slope = covariance / variance, by hand, of 0, 1.1 and 1.9 mm at counts 0, 1000 and 2000: residuals -50, 100 and -50 um."""
    found = calibrated(
        [ReferencePoint(0, 0), ReferencePoint(1.1e-3, 1000), ReferencePoint(1.9e-3, 2000)], Limits(residual=1e-3), METRES, WHERE, "watch"
    )
    np.testing.assert_allclose([found.scale, found.offset], [0.95e-6, 0.05e-3])
    np.testing.assert_allclose(found.residuals, [-0.05e-3, 0.1e-3, -0.05e-3], atol=1e-12)
    about_line = 1.5e-8 * (1 + 1 / 3 + 1 / 2)  # at the ends; one degree of freedom
    rounding = 0.95e-6**2 / 12
    free = (about_line + rounding) ** 2 / about_line**2
    assert found.uncertainty == pytest.approx(t.ppf(norm.cdf(2.0), free) * np.sqrt(about_line + rounding), rel=1e-4)


@pytest.mark.parametrize("points", [3, 4, 8])
def test_the_uncertainty_covers_19_of_20_however_few_the_points(points: int) -> None:
    """Known values that are set with a scatter of 0.1 mm, one reading each: the next one at the end of the span lies within it."""
    random = np.random.default_rng(points)
    true, inside = np.linspace(0.0, 0.2, points), 0
    for _ in range(3000):
        known = true + random.normal(0.0, 1e-4, points)
        found = calibrated(
            [ReferencePoint(*pair) for pair in zip(known, true / 1e-6, strict=True)], Limits(residual=1.0), METRES, WHERE, "watch"
        )
        assert found.uncertainty is not None
        inside += abs(found.offset + found.scale * 0.2 / 1e-6 - (0.2 + random.normal(0.0, 1e-4))) < found.uncertainty
    assert inside / 3000 == pytest.approx(0.9545, abs=0.012)


def test_two_points_say_nothing_of_the_uncertainty_unless_the_reference_does() -> None:
    """Both known values with 0.1 mm: the line's at an end is 0.1 mm, the next value's as much again."""
    points = [ReferencePoint(0.0, 0.0), ReferencePoint(0.2, 200_000.0)]
    assert calibrated(points, Limits(), METRES, WHERE, "watch").uncertainty is None
    assert calibrated(points, Limits(reference=1e-4), METRES, WHERE, "watch").uncertainty == pytest.approx(2e-4 * np.sqrt(2.0), rel=1e-4)


def test_the_uncertainty_covers_the_next_readings() -> None:
    """Over many simulated calibrations of a noisy sensor, about 95 of 100 single readings are within it (k = 2)."""
    random = np.random.default_rng(1)
    scale, noise, inside = 1e-5, 40.0, 0
    for _ in range(400):
        at = (0.0, 0.1, 0.2)
        readings = [random.normal(value / scale, noise, 50) for value in at]
        points = [ReferencePoint(value, float(r.mean()), float(r.std(ddof=1)), 50) for value, r in zip(at, readings, strict=True)]
        found = calibrated(points, Limits(noise=1.0, residual=1.0), METRES, WHERE, "watch")
        true = random.uniform(0, 0.2)
        assert found.uncertainty is not None
        inside += abs(found.offset + found.scale * random.normal(true / scale, noise) - true) < found.uncertainty
    assert 0.92 < inside / 400 < 0.99


@pytest.mark.parametrize(
    ("points", "limits", "reasons"),
    [
        ([ReferencePoint(0, 0)], Limits(), ["different known values are needed: 1 (limit: at least 2)"]),
        ([ReferencePoint(0, 0), ReferencePoint(0, 5000)], Limits(), ["different known values are needed"]),
        (
            [ReferencePoint(0, 500), ReferencePoint(0.1, 560)],
            Limits(),
            ["the readings hardly change between the points: 60 counts (limit: at least 100", "`watch` shows it live"],
        ),
        (
            [ReferencePoint(0, 0, 30, 100), ReferencePoint(0.1, 10_000, 2, 100)],
            Limits(),
            ["the readings at 0 m are too noisy (standard deviation): 0.0003 m (limit: 0.0001 m). Hold the joint still"],
        ),
        (
            [ReferencePoint(0, 0), ReferencePoint(0.1, 10_500), ReferencePoint(0.2, 20_000)],
            Limits(),
            ["the point 0.1 m lies off the line of the others: -0.0033", "(limit: 0.001 m). Is a known value wrong"],
        ),
        ([ReferencePoint(0, 0), ReferencePoint(0.1, 10_010), ReferencePoint(0.2, 20_000)], Limits(residual=1e-5), ["(limit: 1e-05 m)"]),
    ],
)
def test_what_cannot_be_believed_is_refused_with_value_limit_and_unit(
    points: list[ReferencePoint], limits: Limits, reasons: list[str]
) -> None:
    with pytest.raises(ConfigError) as refusal:
        calibrated(points, limits, METRES, WHERE, "watch")
    for reason in reasons:
        assert reason in str(refusal.value)
    assert WHERE in str(refusal.value)


def test_a_refusal_shows_values_and_differences_as_the_rig_file_states_them() -> None:
    """10 degC are 50 degF; 0.5 % of 20 K are 0.18 degF, for a difference has no zero of its own."""
    points = [ReferencePoint(0.0, 0.0), ReferencePoint(10.0, 10_500.0), ReferencePoint(20.0, 20_000.0)]
    with pytest.raises(ConfigError, match=r"the point 50 degF lies off the line of the others: -0\.\d+ degF \(limit: 0\.18 degF\)"):
        calibrated(points, Limits(), ("degF", 1.8, 32.0), WHERE, "watch")
