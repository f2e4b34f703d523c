"""Friction behind a compliance: Eqs 2 and 3 of the paper against quadrature of the element's motion and scipy's integrator."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from scipy.integrate import quad

from tuning.limit_cycles.describing_function import FrictionCompliance


def _played(element: FrictionCompliance, amplitude: float, steps: int = 200_001) -> tuple[np.ndarray, np.ndarray]:
    """Phase and output of the third period, by following stick and slip sample by sample."""
    phase = np.linspace(0.0, 6.0 * pi, 3 * (steps - 1) + 1)
    x = amplitude * np.sin(phase)
    y, slides, out = 0.0, False, np.empty_like(x)
    direction = 1.0
    for i, now in enumerate(x):
        if slides and (now - x[i - 1]) * direction < 0.0:
            slides = False
        if not slides and abs(now - y) >= element.stiction:
            slides, direction = True, np.sign(now - y)
        if slides:
            y = now - direction * element.coulomb
        out[i] = y
    return phase[-steps:], out[-steps:]


@pytest.mark.parametrize("ratio", [1.0, 1.1, 1.2])
@pytest.mark.parametrize("h", [0.1, 0.5, 0.9])
def test_formula_is_the_first_harmonic_of_the_element(ratio: float, h: float) -> None:
    """Row 5: 1e-5. The element is followed by its rules, not by its closed form. Above M = H_s it starts by itself."""
    element = FrictionCompliance.of_ratio(ratio)
    amplitude = 1.0 / h
    if amplitude <= ratio:
        pytest.skip("between (H_s + H_c)/2 and H_s it moves only when it was moving before")
    phase, y = _played(element, amplitude)
    harmonic = np.trapezoid(y * (np.sin(phase) + 1j * np.cos(phase)), phase) / pi / amplitude
    assert abs(harmonic - element.describing_function(amplitude)) < 1e-5


@pytest.mark.parametrize("ratio", [1.0, 1.1, 1.2, 1.5])
def test_closed_form_response_has_the_formula_as_first_harmonic(ratio: float) -> None:
    element = FrictionCompliance.of_ratio(ratio)
    for amplitude in (1.01 * element.smallest_amplitude, 2.0, 7.0):
        breaks = sorted((b + s * pi) % (2 * pi) for b in (pi / 2, pi - np.arcsin((amplitude - ratio - 1) / amplitude)) for s in (0, 1))
        parts = list(zip([0.0, *breaks], [*breaks, 2 * pi], strict=True))
        real = sum(quad(lambda p, m=amplitude: element.response(p, m) * np.sin(p), a, b, epsabs=1e-12)[0] for a, b in parts)
        imaginary = sum(quad(lambda p, m=amplitude: element.response(p, m) * np.cos(p), a, b, epsabs=1e-12)[0] for a, b in parts)
        assert (real + 1j * imaginary) / pi / amplitude == pytest.approx(element.describing_function(amplitude), abs=1e-9)
        assert element.harmonics(amplitude)[0] == pytest.approx(element.describing_function(amplitude), abs=1e-4)


def test_sample_values() -> None:
    values = [FrictionCompliance(1.0, 1.0).describing_function(2.0), FrictionCompliance(1.2, 1.0).describing_function(1 / 0.3)]
    assert np.array(values) == pytest.approx(np.array([0.5 - 0.31831j, 0.748127 - 0.268526j]), abs=5e-6)


@pytest.mark.parametrize(("ratio", "end"), [(1.1, -16.493j), (1.2, -8.639j)])
def test_curve_ends_on_the_negative_imaginary_axis(ratio: float, end: complex) -> None:
    """The paper's statement, right for H_s > H_c."""
    element = FrictionCompliance.of_ratio(ratio)
    value = -1.0 / element.describing_function(element.smallest_amplitude * (1 + 1e-9))
    assert value == pytest.approx(end, abs=0.01)


def test_below_half_the_travel_nothing_moves() -> None:
    element = FrictionCompliance.of_ratio(1.2)
    assert element.describing_function(1.09) == 0.0
    assert not element.response(np.linspace(0, 6, 50), 1.09).any()


def test_without_stiction_it_is_backlash() -> None:
    """Backlash of half gap H_c (Gelb, Vander Velde): real part ½ + (asin c + c√(1−c²))/π with c = 1 − 2h, imaginary −4h(1−h)/π."""
    h = 0.35
    c = 1 - 2 * h
    expected = 0.5 + (np.arcsin(c) + c * np.sqrt(1 - c * c)) / pi - 4j * h * (1 - h) / pi
    assert FrictionCompliance.of_ratio(1.0).describing_function(1 / h) == pytest.approx(expected, abs=1e-12)
