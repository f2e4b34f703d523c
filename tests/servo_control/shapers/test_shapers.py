"""Every shaper against an independent realisation (numpy convolution, scipy's lfilter, inverted phase); rates, rest, snapshots."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from scipy import signal
from scipy.integrate import cumulative_trapezoid

from config.errors import ManeuverError
from config.schema.rig import Rig
from servo_control.link.kinematics import forward
from servo_control.link.link_mode import LinkFrequency
from servo_control.planning.planning import plan_run
from servo_control.planning.prediction import predict
from servo_control.shapers.shaper import Shaper
from tests.support.servo_control.testbed_runs import INCH, request, shipped

PERIOD_S = 0.001
SHAPERS: list[dict[str, Any]] = [
    {"kind": kind, **more}
    for kind, more in (
        ("none", {}), ("zv", {}), ("zvd", {}), ("ei", {}), ("two_hump_ei", {}), ("three_term", {"delay_s": 0.08}),
        ("notch", {}), ("robust_notch", {}), ("adaptive", {}), ("adaptive_zv", {}),
        ("adaptive_coefficients", {}), ("adaptive_delay", {}),
    )
]  # fmt: skip
NAMES = [shaper["kind"] for shaper in SHAPERS]
BOTH = {"joints": ["rotary", "prismatic"]}


PREDICTED: dict[str, dict[str, np.ndarray]] = {}  # several tests look at the same run of the session's rig and maneuver


def _shaped(rig: Rig, maneuver: dict[str, Any], shaper: dict[str, Any]) -> dict[str, np.ndarray]:
    """Read only: the arrays are shared."""
    key = json.dumps([maneuver["name"], shaper])
    if key not in PREDICTED:
        cycles = list(predict(rig, plan_run(rig, request(maneuver, shaper=shaper))))
        names = ("target", "target_rate", "reference", "reference_rate")
        PREDICTED[key] = {name: np.array([getattr(cycle, name) for cycle in cycles]) for name in names}
        for values in PREDICTED[key].values():
            values.setflags(write=False)
    return PREDICTED[key]


def _omega(rig: Rig, extension: np.ndarray) -> np.ndarray:
    link = rig.link_mode
    assert link is not None
    mass = link.payload_kg + 33 / 140 * link.mass_per_length_kg_per_m * extension
    return np.sqrt(3 * link.bending_stiffness_N_m2 / (extension**3 * mass) * (1 - link.damping_ratio**2))


@pytest.mark.parametrize("shaper", SHAPERS, ids=NAMES)
def test_starts_and_ends_at_the_target_and_rates_are_slopes(rig: Rig, paper_y30: dict[str, Any], shaper: dict[str, Any]) -> None:
    data = _shaped(rig, paper_y30, shaper | BOTH if shaper["kind"] != "none" else shaper)
    target, reference, rate = data["target"], data["reference"], data["reference_rate"]
    assert reference[0] == pytest.approx(target[0], abs=1e-15)
    assert reference[-1] == pytest.approx(target[-1], abs=3e-6)
    slope = np.gradient(reference, PERIOD_S, axis=0)
    assert abs(slope - rate).max() < 0.01
    assert np.sqrt(((slope - rate) ** 2).mean()) < 5e-4


@pytest.mark.parametrize("shaper", SHAPERS[1:6], ids=NAMES[1:6])
def test_fixed_shapers_are_convolutions(rig: Rig, paper_y30: dict[str, Any], shaper: dict[str, Any]) -> None:
    data = _shaped(rig, paper_y30, shaper)
    plan = plan_run(rig, request(paper_y30, shaper=shaper))
    t = np.arange(len(data["target"])) * PERIOD_S
    u = data["target"][:, 0]
    expected = sum(a * np.interp(t - delay, t, u) for a, delay in zip(*plan.shaper.impulses(), strict=True))
    assert data["reference"][:, 0] == pytest.approx(expected, abs=1e-12)
    assert data["reference"][:, 1] == pytest.approx(data["target"][:, 1], abs=0)


@pytest.mark.parametrize(("kind", "spread"), [("notch", (1.0,)), ("robust_notch", (0.9, 1.11))])
def test_notches_are_the_bilinear_transform(rig: Rig, paper_y30: dict[str, Any], kind: str, spread: tuple[float, ...]) -> None:
    data = _shaped(rig, paper_y30, {"kind": kind, "frequency_Hz": 4.0})
    expected = data["target"][:, 0]
    omega_n = 2 * np.pi * 4.0 / np.sqrt(1 - 0.005**2)
    for share in spread:
        w = share * omega_n
        b, a = signal.bilinear([1, 2 * 0.005 * w, w * w], [1, 2 * 0.7 * w, w * w], 1 / PERIOD_S)
        expected = signal.lfilter(b, a, expected)
    assert data["reference"][:, 0] == pytest.approx(expected, abs=1e-11)


def test_phase_domain_emits_after_half_and_whole_cycles(rig: Rig, paper_y30: dict[str, Any]) -> None:
    """Rotary only: the phase is that of the target extension, integrated and inverted here by numpy."""
    data = _shaped(rig, paper_y30, {"kind": "adaptive"})
    t = np.arange(len(data["target"])) * PERIOD_S
    phase = cumulative_trapezoid(_omega(rig, data["target"][:, 1]), t, initial=0.0)
    k = np.exp(-np.pi * 0.005 / np.sqrt(1 - 0.005**2))
    weights = np.array([1, 2 * k, k * k]) / (1 + k) ** 2
    expected = sum(w * np.interp(np.interp(phase - i * np.pi, phase, t, left=0.0), t, data["target"][:, 0]) for i, w in enumerate(weights))
    assert data["reference"][:, 0] == pytest.approx(expected, abs=1e-9)


def test_phase_domain_with_both_joints_follows_the_shaped_extension(rig: Rig, paper_y30: dict[str, Any]) -> None:
    data = _shaped(rig, paper_y30, {"kind": "adaptive", **BOTH})
    t = np.arange(len(data["target"])) * PERIOD_S
    phase = cumulative_trapezoid(_omega(rig, data["reference"][:, 1]), t, initial=0.0)
    for j in (0, 1):
        k = np.exp(-np.pi * 0.005)
        weights = np.array([1, 2 * k, k * k]) / (1 + k) ** 2
        expected = sum(
            w * np.interp(np.interp(phase - i * np.pi, phase, t, left=0.0), t, data["target"][:, j]) for i, w in enumerate(weights)
        )
        assert data["reference"][:, j] == pytest.approx(expected, abs=3e-5)  # the loop uses the extension of the cycle before


def test_both_joints_keep_the_line_straight(rig: Rig, paper_y30: dict[str, Any]) -> None:
    """Rotary only bends the line by 15 to 24 mm, both joints by 0.3 to 0.5 mm."""

    def bow(shaper: dict[str, Any]) -> float:
        reference = _shaped(rig, paper_y30, shaper)["reference"]
        return max(abs(forward(*row)[1] - 30 * INCH) for row in reference)

    assert 0.010 < bow({"kind": "adaptive"}) < 0.030
    assert bow({"kind": "adaptive", **BOTH}) < 0.0006


@pytest.mark.parametrize(
    "shaper",
    [{"kind": "adaptive", **BOTH}, {"kind": "adaptive_zv", **BOTH}, {"kind": "zero_delay"}],
    ids=["adaptive", "adaptive_zv", "zero_delay"],
)
@pytest.mark.parametrize(("line", "y0"), [("paper_line", 40 * INCH), ("paper_line_y30", 30 * INCH)])
def test_the_commanded_path_stays_within_2_mm_of_the_line(rig: Rig, line: str, y0: float, shaper: dict[str, Any]) -> None:
    """Every reference of both joints, as a point."""
    plan = plan_run(rig, request(shipped(line), [0.0, y0], shaper))
    away = [abs(forward(*cycle.reference)[1] - y0) for cycle in predict(rig, plan)]
    assert len(away) > 16_000
    assert max(away) < 0.002


@pytest.mark.parametrize("shaper", SHAPERS, ids=NAMES)
def test_flush_time_is_enough(rig: Rig, paper_y30: dict[str, Any], shaper: dict[str, Any]) -> None:
    """A step at 36 in, then rest: after flush_s the reference is within 3e-6 of the step."""
    made, start = _made(rig, paper_y30, shaper), [0.0, 0.9144]
    made.reset(start)
    reference, rate = list(start), [0.0, 0.0]
    made.step(start, [0.0, 0.0], reference, rate)
    for _ in range(int(made.flush_s / PERIOD_S) + 2):
        made.step([0.1, 0.9144], [0.0, 0.0], reference, rate)
    assert reference[0] == pytest.approx(0.1, abs=3e-6)


@pytest.mark.parametrize("shaper", SHAPERS, ids=NAMES)
def test_snapshot_continues_bit_for_bit(rig: Rig, paper_y30: dict[str, Any], shaper: dict[str, Any]) -> None:
    setup = plan_run(rig, request(paper_y30, shaper=shaper)).shaper
    one, other = setup.build(), setup.build()
    one.reset([0.0, 0.762])
    rng = np.random.default_rng(1)
    path = np.cumsum(rng.normal(0, 1e-4, (3000, 2)), axis=0) + [0.0, 0.762]
    outputs = []
    for n, row in enumerate(path.tolist()):
        reference, rate = [0.0, 0.0], [0.0, 0.0]
        if n == 1500:
            other.restore(json.loads(json.dumps(one.snapshot())))
        one.step(row, [0.01, -0.01], reference, rate)
        outputs.append((*reference, *rate))
        if n >= 1500:
            other.step(row, [0.01, -0.01], reference, rate)
            assert (*reference, *rate) == outputs[-1]


def _made(rig: Rig, maneuver: dict[str, Any], shaper: dict[str, Any]) -> Shaper:
    return plan_run(rig, request(maneuver, shaper=shaper)).shaper.build()


def test_focal_frequencies(rig: Rig, paper_y30: dict[str, Any]) -> None:
    found = {f: plan_run(rig, request(paper_y30, shaper={"kind": "zvd", "focal": f})).shaper.focal_Hz for f in ("initial", "final", "mid")}
    assert found == pytest.approx({"initial": 5.41, "final": 3.20, "mid": (5.41 * 3.20) ** 0.5}, rel=2e-3)
    explicit = plan_run(rig, request(paper_y30, shaper={"kind": "zvd", "frequency_Hz": 4.2})).shaper
    assert explicit.focal_Hz == pytest.approx(4.2)


TABLE_5_5 = {12: 21.528, 24: 7.578, 36: 4.107, 48: 2.656, 60: 1.892}


@pytest.mark.parametrize("inches", TABLE_5_5)
def test_link_frequency(rig: Rig, inches: int) -> None:
    """Against the exact frequency equation's table, 45 lb: at most 0.02 % high."""
    assert rig.link_mode is not None
    assert LinkFrequency(rig.link_mode).frequency_Hz(inches * INCH) == pytest.approx(TABLE_5_5[inches], rel=4e-4)


UNSAFE = [
    ({"kind": "three_term", "focal": "final"}, "ω_d T"),
    ({"kind": "three_term", "delay_s": 0.02}, "ω_d T"),
    ({"kind": "adaptive_coefficients", "delay_s": 0.3}, "ω_d T"),
    ({"kind": "zvdd"}, "unknown kind"),
    ({"kind": "zvd", "focal": "middle"}, "unknown focal"),
    ({"kind": "zvd", "joint": ["rotary"]}, "unknown key"),
    ({"kind": "zvd", "joints": ["elbow"]}, "no such joint"),
    ({"kind": "zvd", "frequency_Hz": -1}, "out of range"),
]


@pytest.mark.parametrize(("shaper", "words"), UNSAFE)
def test_unsafe_or_unknown_shapers_are_refused(rig: Rig, paper_y30: dict[str, Any], shaper: dict[str, Any], words: str) -> None:
    with pytest.raises(ManeuverError, match=words) as refusal:
        plan_run(rig, request(paper_y30, shaper=shaper))
    assert refusal.value.refusal.limit
