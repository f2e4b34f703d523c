"""The link's constants from a run at constant extension: signals from the equation of motion, then the whole rig with its feedback on."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from config.loading.load import LoadedRig, load_rig, rig_from_text
from config.loading.overrides import apply_overrides
from config.schema.rig import LinkMode, Rig
from daemon.lockstep import run_lockstep
from recording.files.reader import read_log
from tuning.experiments.experiments import Campaign, default_places, experiments, must_ring
from tuning.link_and_payload.free_vibration import free_vibrations
from tuning.link_and_payload.link_map import link_map
from tuning.link_and_payload.payload import clamped_Hz
from tuning.link_and_payload.tip_balance import TipBalance, link_damping, tip_balance
from tuning.link_and_payload.tip_record import TipRecord, tip_records

PERIOD_S, SECONDS = 0.001, 6.0
LAG_S = 0.0012


def _link(rig: Rig) -> LinkMode:
    assert rig.link_mode is not None
    return rig.link_mode


def _run(link: LinkMode, length_m: float, damping: float, lag_s: float = 0.0) -> TipRecord:
    """A joint that jerks about (its motion is not one of the link's own); the deflection solves the link's equation exactly between
    samples of constant joint acceleration; the accelerometer follows with a first-order lag."""
    own = link.mass_per_length_kg_per_m * length_m
    arm = length_m * (link.payload_kg + 11 / 40 * own) / (link.payload_kg + 33 / 140 * own)
    omega, fine = 2 * pi * clamped_Hz(link, link.payload_kg, length_m), 10
    step = PERIOD_S / fine
    t = step * np.arange(round(SECONDS / step))
    push = 1.5 * np.sin(2 * pi * 1.3 * t) * np.exp(-0.5 * t) + 0.8 * np.sign(np.sin(2 * pi * 0.7 * t))
    root = omega * np.sqrt(1 - damping**2)
    c, s, keep = np.cos(root * step), np.sin(root * step), np.exp(-damping * omega * step)
    w = rate = 0.0
    rows = np.empty((len(t), 2))
    for k, theta_dd in enumerate(push):
        still = -arm * theta_dd / omega**2
        rows[k] = w, -arm * theta_dd - omega**2 * w - 2 * damping * omega * rate
        away, slope = w - still, (rate + damping * omega * (w - still)) / root
        w, rate = still + keep * (c * away + s * slope), keep * (c * rate - s * (omega**2 * away + damping * omega * rate) / root)
    theta = np.cumsum(np.cumsum(push)) * step**2
    acceleration = rows[:, 1] + length_m * push
    if lag_s > 0.0:
        share = lag_s / (lag_s + step)  # late by share / (1 − share) steps
        acceleration = lfilter([1 - share], [1, -share], acceleration)
    coarse = slice(None, None, fine)
    return TipRecord(1, PERIOD_S, acceleration[coarse], rows[coarse, 0], theta[coarse], np.full(len(t), length_m)[coarse], ())


def test_frequency_and_damping_of_a_driven_link(rig: Rig) -> None:
    link = _link(rig)
    for length_m in (0.67, 1.2):
        found = tip_balance(_run(link, length_m, 0.008), link)
        assert found is not None
        assert found.clamped_Hz == pytest.approx(clamped_Hz(link, link.payload_kg, length_m), rel=1e-3)
        assert found.apparent_damping == pytest.approx(0.008, abs=5e-4)


def test_the_lag_between_the_sensors_is_told_from_damping_by_several_extensions(rig: Rig) -> None:
    link = _link(rig)
    balances = [tip_balance(_run(link, length_m, 0.006, LAG_S), link) for length_m in (0.6, 0.9, 1.2, 1.5)]
    whole = [balance for balance in balances if balance is not None]
    assert whole[0].apparent_damping < -0.01
    found = link_damping(whole)
    assert found is not None
    assert found.lag_s == pytest.approx(LAG_S, rel=0.01)
    assert found.damping_ratio == pytest.approx(0.006, abs=5e-4)
    assert found.by_run == pytest.approx([0.006] * 4, abs=8e-4)
    assert link_damping(whole[:1]) is None
    same = [replace(whole[0], clamped_Hz=whole[0].clamped_Hz * (1 + 0.01 * n)) for n in range(4)]
    assert link_damping(same) is None


def test_what_says_nothing_is_left_out(rig: Rig) -> None:
    link = _link(rig)
    record = _run(link, 1.2, 0.005)
    assert tip_balance(replace(record, deflection=None), link) is None
    assert tip_balance(replace(record, acceleration=1e-3 * record.acceleration), link) is None
    moving = replace(record, extension=np.linspace(1.0, 1.3, len(record.extension)))
    assert tip_balance(moving, link) is None


def test_a_rig_that_measures_the_deflection_need_not_ring(rig: Rig) -> None:
    assert must_ring(rig, "map") == ()
    blind = rig.model_copy(update={"signals": {name: signal for name, signal in rig.signals.items() if name != "tip.deflection"}})
    assert must_ring(blind, "all")[0] == "end_point.gain=0"
    assert must_ring(blind, "sweep") == ()


def _mapped(tmp_path: Path, shares: slice) -> list[TipRecord]:
    loaded = load_rig("ornl_testbed")
    wanted = experiments(loaded.rig, Campaign("map", "rotary", (0.3,), default_places(loaded.rig, "map")[shares]))
    records = []
    for number, experiment in enumerate(wanted, 1):
        text = apply_overrides(loaded.text, experiment.overrides)
        request = {"maneuver": {"text": experiment.maneuver, "name": experiment.name}, "approach": True}
        (path,) = run_lockstep(LoadedRig(rig_from_text(text), text, loaded.path), [request], tmp_path, number)
        records += tip_records(read_log(path))
    return records


@pytest.mark.slow
def test_the_map_of_the_whole_rig_with_its_feedback_on(rig: Rig, tmp_path: Path) -> None:
    """0.49 to 1.52 m, shipped servo and end-point feedback: frequencies within 0.4 %, damping 0.5 % within its interval of 0.05 %."""
    link = _link(rig)
    records = _mapped(tmp_path, slice(1, None))
    balances: list[TipBalance] = [found for record in records if (found := tip_balance(record, link)) is not None]
    assert len(balances) == len(records) == 6
    found = link_map(link, [hold for record in records for hold in free_vibrations(record, link)], balances)
    for point in found.points:
        assert point.clamped_Hz == pytest.approx(point.believed_Hz, rel=0.004)
        assert abs(point.clamped_Hz - point.believed_Hz) < 3.0 * point.clamped_sigma_Hz
        assert point.damping_ratio == pytest.approx(0.005, abs=0.001)
    assert found.damping_uncertainty < 6e-4
    assert abs(found.damping_ratio - 0.005) < found.damping_uncertainty
    assert found.sensor_lag_s == pytest.approx(1.14e-3, abs=0.1e-3)  # 100 Hz, sampled: k / (1 − k) periods, k = exp(−2π 0.1)
