"""Shipped maneuvers and excitation signals: derivatives, spectra, steps, limits."""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import config
from config.errors import ManeuverError
from config.schema.maneuver import maneuver_content, maneuver_from_content
from config.schema.rig import Rig
from servo_control.path.multisine import Multisine, odd_harmonics
from servo_control.path.waves import Stairs, Sweep, Triangle, Wave
from servo_control.planning.planning import plan_run
from tests.support.servo_control.testbed_runs import content, request, shipped

HOME = [0.0, 0.9144]
SHIPPED = sorted(path.stem for path in (Path(config.__file__).parent / "maneuvers").glob("*.yaml"))


def _sampled(wave: Wave, step_s: float = 1e-3) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    t = np.arange(0.0, wave.duration_s, step_s)
    return t, np.array([wave.at(x) for x in t])


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_maneuvers_run_on_the_testbed_from_anywhere(rig: Rig, name: str) -> None:
    """Checked by planning; positions are continuous from cycle to cycle within the rate limit."""
    plan = plan_run(rig, request(shipped(name), [0.1, 1.0], approach=True))
    assert plan.request.maneuver["name"] == name
    t = np.arange(0, plan.duration_s, 0.01)
    positions = np.array([plan.program.at(x, plan.program.index_at(x))[0] for x in t])
    for j, joint in enumerate(rig.joints.values()):
        assert abs(np.diff(positions[:, j])).max(initial=0.0) <= joint.rate_limit * 0.01 * 1.001
        assert positions[:, j].min() >= joint.travel[0]
        assert positions[:, j].max() <= joint.travel[1]


@given(st.floats(-1e3, 1e3), st.sampled_from(["deg", "rad", "in", "mm", ""]))
def test_content_of_a_run_request_is_a_fixed_point(value: float, unit: str) -> None:
    """What goes into the log re-validates to itself, bit for bit, whatever unit was written."""
    once = content("jog", joint="rotary", by=f"{value} {unit}")
    assert maneuver_content(maneuver_from_content(once)) == once


WAVES: list[tuple[str, Wave]] = [
    ("logarithmic", Sweep(0.02, 0.2, 5.0, 20.0, 1.0, logarithmic=True)),
    ("linear", Sweep(0.02, 5.0, 0.2, 20.0, 1.0, logarithmic=False)),
    ("constant", Sweep(0.02, 2.0, 2.0, 10.0, 1.0, logarithmic=True)),
    ("multisine", Multisine(0.02, odd_harmonics(0.1, 4.0, 10.0, 20), 10.0, 2, 1.0, 3, 2.5)),
]


@pytest.mark.parametrize(("name", "wave"), WAVES)
def test_rates_and_accelerations_are_derivatives(name: str, wave: Wave) -> None:
    t, data = _sampled(wave)
    w, rate, acceleration = data.T
    assert abs(w).max() <= 0.02 * (1 + 1e-5)
    assert w[0] == 0.0
    assert wave.at(wave.duration_s)[0] == 0.0
    assert np.gradient(w, t)[1:-1] == pytest.approx(rate[1:-1], abs=2e-3 * abs(rate).max())
    assert np.gradient(rate, t)[1:-1] == pytest.approx(acceleration[1:-1], abs=5e-3 * abs(acceleration).max())


@pytest.mark.parametrize("logarithmic", [True, False])
def test_sweep_passes_its_frequencies(logarithmic: bool) -> None:
    """Instantaneous frequency from the analytic phase of two quadrature-free zero crossings in mid sweep."""
    t, data = _sampled(Sweep(1.0, 1.0, 9.0, 30.0, 0.0, logarithmic=logarithmic), 1e-4)
    w = data[:, 0]
    up = t[1:][(w[:-1] < 0) & (w[1:] >= 0)]
    centre, frequency = (up[1:] + up[:-1]) / 2, 1 / np.diff(up)
    expected = 9.0 ** (centre / 30.0) if logarithmic else 1.0 + 8.0 * centre / 30.0
    assert frequency == pytest.approx(expected, rel=0.01)


def test_multisine_has_odd_lines_only_and_a_low_crest() -> None:
    harmonics = odd_harmonics(0.1, 4.0, 10.0, 15)
    wave = Multisine(0.5, harmonics, 10.0, 2, 1.0, 3, 2.5)
    periods = np.array([wave.at(1.0 + n * 10.0 / 4096)[0] for n in range(8192)])
    assert periods[:4096] == pytest.approx(periods[4096:], abs=1e-12)
    lines = np.abs(np.fft.rfft(periods[:4096])) / 2048
    assert all(h % 2 for h in harmonics)
    assert len(harmonics) <= 15
    assert np.delete(lines, harmonics).max() < 1e-5 * lines.max()
    assert lines[list(harmonics)] == pytest.approx(lines[harmonics[0]], rel=1e-4)
    assert abs(periods).max() == pytest.approx(0.5, rel=1e-3)
    assert abs(periods).max() / periods.std() <= 2.5


def test_a_crest_limit_that_is_not_met_is_told_with_one_that_is() -> None:
    """The crest factor told is above the limit told, and what it says to write is enough."""
    harmonics = odd_harmonics(0.1, 4.0, 10.0, 20)
    for crest_limit in (1.6, 1.9, 2.0):
        with pytest.raises(ManeuverError, match="no phases with a low enough crest factor") as refused:
            Multisine(1.0, harmonics, 10.0, 1, 1.0, 3, crest_limit)
        told = refused.value.refusal
        assert float(told.value) > float(told.limit.partition(",")[0])
        Multisine(1.0, harmonics, 10.0, 1, 1.0, 3, float(told.mend["crest_limit"] or 0))


def test_multisine_depends_on_its_seed_alone() -> None:
    harmonics = odd_harmonics(0.1, 2.0, 10.0, 10)
    first, again, other = (Multisine(1.0, harmonics, 10.0, 1, 1.0, seed, 3.0) for seed in (1, 1, 2))
    assert [first.at(0.1 * n) for n in range(120)] == [again.at(0.1 * n) for n in range(120)]
    assert first.at(5.0) != other.at(5.0)


def test_triangle_and_stairs_in_volts() -> None:
    _t, data = _sampled(Triangle(2.0, 0.5, 3))
    assert Triangle(2.0, 0.5, 3).duration_s == 48.0
    assert (data[:, 0].max(), data[:, 0].min()) == pytest.approx((2.0, -2.0), abs=1e-3)
    assert abs(np.diff(data[:, 0])).max() <= 0.5e-3 * (1 + 1e-9)
    levels = [Stairs(-0.2, 3, 0.5).at(0.25 + 0.5 * k)[0] for k in range(6)]
    assert levels == pytest.approx([-0.2, -0.4, -0.6, -0.4, -0.2, 0.0])


KINDS: list[dict[str, Any]] = [
    content("slow_triangle", joint="rotary", amplitude="2 deg", rate="1 deg/s", cycles=1),
    content("staircase", joint="prismatic", step="-1 cm", steps=3, hold=0.5),
    content("fast_strokes", joint="prismatic", by="0.2 m", strokes=2, hold=0.5),
]


@pytest.mark.parametrize("maneuver", KINDS, ids=[m["kind"] for m in KINDS])
def test_reference_kinds_visit_their_levels_and_return(rig: Rig, maneuver: dict[str, Any]) -> None:
    plan = plan_run(rig, request(maneuver, HOME))
    ends = [plan.program.at(s.end_s, i)[0] for i, s in enumerate(plan.segments) if s.kind == "move"]
    expected = {
        "slow_triangle": [(2 * pi / 180, 0.9144), (-2 * pi / 180, 0.9144), (0.0, 0.9144)],
        "staircase": [(0.0, 0.9144 + 0.01 * level) for level in (-1, -2, -3, -2, -1, 0)],
        "fast_strokes": [(0.0, 1.1144), (0.0, 0.9144)],
    }[maneuver["kind"]]
    assert np.array(ends) == pytest.approx(np.array(expected), abs=1e-12)


def test_excitation_of_the_command_leaves_the_reference(rig: Rig) -> None:
    plan = plan_run(rig, request(content("staircase", joint="rotary", on="command", step="0.1 V", steps=2, hold=1.0), HOME))
    samples = [plan.program.at(x, 0) for x in (0.5, 1.5, 2.5, 3.5)]
    assert [s[3][0] for s in samples] == pytest.approx([0.1, 0.2, 0.1, 0.0])
    assert all(s[0] == tuple(HOME) and s[3][1] == 0.0 for s in samples)
