"""Figure 6 and what is really there: intersections, exact cycles of the same block diagram, and scipy following it with events."""

from __future__ import annotations

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import tf2ss

from tuning.arrays import Complexes, Floats
from tuning.limit_cycles.describing_function import FrictionCompliance
from tuning.limit_cycles.exact_cycle import Cycle, ExactLoop, gain_for_frequency
from tuning.limit_cycles.limit_cycles import first_gain_with_cycle, predict_limit_cycles
from tuning.linear.margins import margins
from tuning.transfer import EQ4, lag_lead

# gain factor, H_s/H_c, describing function (Hz, M/H_c), exact (Hz, M/H_c, load/H_c): Eq 4 in a unity loop
TABLE = [
    (0.8, 1.1, (0.305, 1.0505), (0.451, 1.062, 0.062)),
    (0.8, 1.2, (0.587, 1.102), (0.836, 1.125, 0.125)),
    (1.0, 1.1, (0.383, 1.0508), (0.599, 1.067, 0.067)),
    (1.0, 1.2, (0.740, 1.1032), (1.100, 1.134, 0.134)),
    (1.2, 1.1, (0.463, 1.0512), (0.772, 1.073, 0.073)),
    (1.2, 1.2, (0.900, 1.1047), (1.400, 1.146, 0.146)),
    (2.0, 1.1, (0.806, 1.054), (2.15, 1.140, 0.140)),
    (2.0, 1.2, (1.643, 1.117), (3.53, 1.281, 0.281)),
    (2.5, 1.0, (8.72, 2.92), (8.91, 3.12, 2.12)),
    (2.5, 1.2, (8.78, 2.99), (8.95, 3.18, 2.18)),
    (3.0, 1.0, (11.08, 9.02), (11.09, 9.10, 8.10)),
    (3.0, 1.2, (11.08, 9.05), (11.09, 9.13, 8.13)),
]


def _loop(k: float) -> control.TransferFunction:
    return k * EQ4


def _on_axis(loop: control.TransferFunction, omega: Floats) -> Complexes:
    return loop(1j * omega)


def _predicted(k: float, ratio: float) -> list:
    return predict_limit_cycles(_loop(k), FrictionCompliance.of_ratio(ratio))


def _exact(k: float, ratio: float, start: float = 1.0) -> Cycle | None:
    return ExactLoop(_loop(k), FrictionCompliance.of_ratio(ratio)).march(start)


@pytest.mark.parametrize(
    ("k", "crossover", "phase", "gain", "peak"),
    [(0.8, 4.59, 52.8, 13.0, 1.65), (1.0, 5.53, 45.5, 11.07, 1.86), (1.2, 6.37, 39.0, 9.5, 2.10)],
)
def test_margins_of_eq_4(k: float, crossover: float, phase: float, gain: float, peak: float) -> None:
    """Row 4. Gain margin in closed form: 140 · 6150 / 240810 / k."""
    found = margins(lambda w: _on_axis(_loop(k), w))
    assert found.crossover_Hz == pytest.approx(crossover, abs=0.02)
    assert found.phase_margin_deg == pytest.approx(phase, abs=0.2)
    assert found.gain_margin_dB == pytest.approx(20 * np.log10(140 * 6150 / 240810 / k), abs=1e-6)
    assert found.gain_margin_dB == pytest.approx(gain, abs=0.05)
    assert found.sensitivity_peak == pytest.approx(peak, abs=0.01)


@pytest.mark.parametrize(("k", "ratio", "expected", "_exact_row"), TABLE)
def test_intersections(k: float, ratio: float, expected: tuple[float, float], _exact_row: object) -> None:
    """Row 6: 1 %. The nearest of the stable ones; where three exist the table names the outer one."""
    best = min((p for p in _predicted(k, ratio) if p.stable), key=lambda p: abs(p.frequency_Hz - expected[0]))
    assert (best.frequency_Hz, best.amplitude) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("k", [0.8, 1.0, 1.2])
def test_nothing_intersects_without_stiction(k: float) -> None:
    """Row 6; the exact loop comes to rest as well."""
    assert _predicted(k, 1.0) == []
    assert _exact(k, 1.0) is None


@pytest.mark.parametrize(("k", "ratio", "_predicted_row", "expected"), TABLE)
def test_exact_cycles(k: float, ratio: float, _predicted_row: object, expected: tuple[float, float, float]) -> None:
    """Row 7: 3 % in frequency and amplitude."""
    cycle = _exact(k, ratio)
    assert cycle is not None
    assert (cycle.frequency_Hz, cycle.amplitude, cycle.load_amplitude) == pytest.approx(expected, rel=0.03)


def test_cycle_agrees_with_scipy_following_the_diagram() -> None:
    """Stick and slip with DOP853 and its event finder, k = 2, H_s/H_c = 1.2."""
    a, b, c, _ = tf2ss(2.0 * np.array([240810.0]), [1.0, 140.0, 6150.0, 0.0])
    b, c = b[:, 0], c[0]
    cycle = _exact(2.0, 1.2)
    assert cycle is not None
    z, load, sign, t, turns, top = np.zeros(3), 1.0, -1.0, 0.0, [], 0.0
    for _ in range(60):
        for stuck in (True, False):
            held, up = load, sign

            def slope(_: float, z: Floats, stuck: bool = stuck, held: float = held, up: float = up) -> Floats:
                return a @ z - b * (held if stuck else c @ z - up)

            def event(_: float, z: Floats, stuck: bool = stuck, held: float = held, up: float = up) -> float:
                return up * (c @ z - held) - 1.2 if stuck else -up * (c @ (a @ z - b * (c @ z - up)))

            event.terminal, event.direction = True, 1.0  # type: ignore[attr-defined]
            solution = solve_ivp(slope, (t, t + 30), z, "DOP853", events=event, rtol=1e-10, atol=1e-12)
            z, t = solution.y[:, -1], float(solution.t[-1])
        load, top = float(c @ z) - sign, abs(float(c @ z))
        turns.append(t)
        sign = -sign
    assert 0.5 / (turns[-1] - turns[-2]) == pytest.approx(cycle.frequency_Hz, rel=1e-6)
    assert top == pytest.approx(cycle.amplitude, rel=1e-6)


def test_middle_branch_is_unstable_and_a_threshold() -> None:
    """k = 2.5, H_s/H_c = 1.2: 2.36, 5.48 and 8.78 Hz, stable, unstable, stable; an exact unstable cycle lies between."""
    found = _predicted(2.5, 1.2)
    assert [p.frequency_Hz for p in found] == pytest.approx([2.36, 5.48, 8.78], rel=0.01)
    assert [p.stable for p in found] == [True, False, True]


def test_warning_where_the_filter_hypothesis_fails() -> None:
    """It is doubtful exactly where the describing function is more than 10 % off the exact frequency."""
    for k, ratio in [(0.8, 1.1), (1.0, 1.2), (2.0, 1.2), (2.5, 1.0), (3.0, 1.2)]:
        cycle = _exact(k, ratio)
        assert cycle is not None
        prediction = min((p for p in _predicted(k, ratio) if p.stable), key=lambda p: abs(p.frequency_Hz - cycle.frequency_Hz))
        off = abs(prediction.frequency_Hz / cycle.frequency_Hz - 1.0)
        assert prediction.doubtful == (off > 0.1)
        assert bool(prediction.warning) == prediction.doubtful


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ratio", "gains"),
    [(1.05, (2.290, 2.293, 2.297)), (1.1, (2.265, 2.273, 2.282)), (1.2, (2.183, 2.214, 2.240)), (1.5, (1.851, 1.949, 2.035))],
)
def test_gain_that_gives_five_to_six_hertz(ratio: float, gains: tuple[float, ...]) -> None:
    """Row 7, second half, and the table of what gives 5, 5.5 and 6 Hz in this structure."""
    element = FrictionCompliance.of_ratio(ratio)
    found = [gain_for_frequency(EQ4, element, f, 2.1) for f in (5.0, 5.5, 6.0)]
    assert found == pytest.approx(gains, rel=0.003)


def test_first_gain_with_an_intersection() -> None:
    """H_s = H_c: tangency at k = 2.42; exact between 2.2 and 2.3."""
    k = first_gain_with_cycle(EQ4, FrictionCompliance.of_ratio(1.0), 2.0, 3.0)
    assert k == pytest.approx(2.42, abs=0.01)
    assert _exact(2.2, 1.0, 10.0) is None
    assert _exact(2.3, 1.0, 10.0) is not None


@pytest.mark.parametrize(
    ("controller", "expected"),
    [
        (lag_lead(0.71, ()), (None, (0.39, 0.061), (0.73, 0.121))),
        (lag_lead(1.4586, ((59.58, 595.8),)), (None, (0.77, 0.058), (1.45, 0.115))),
        (lag_lead(1.4586 * 6, ((59.58, 595.8), (8.0, 8.0 / 6))), ((1.78, 0.134), (1.92, 0.148), (2.30, 0.188))),
    ],
)
def test_cycles_of_compensated_loops(controller: control.TransferFunction, expected: tuple[tuple[float, float] | None, ...]) -> None:
    """Lag action creates hunting even for H_s = H_c (frequency within 2 %, load amplitude within 3 %)."""
    for ratio, row in zip((1.0, 1.1, 1.2), expected, strict=True):
        cycle = ExactLoop(controller * EQ4, FrictionCompliance.of_ratio(ratio)).march(1.0)
        assert (cycle is None) == (row is None)
        if cycle is not None and row is not None:
            assert (cycle.frequency_Hz, cycle.load_amplitude) == pytest.approx(row, rel=0.03)
