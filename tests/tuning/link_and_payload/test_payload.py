"""An unknown payload from one ordinary move of the whole rig, as it is logged; the rig file goes on believing 45 lb."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from config.errors import LogError
from config.loading.load import LoadedRig, load_rig, rig_from_text
from config.loading.overrides import apply_overrides
from config.schema.rig import Rig
from daemon.lockstep import run_lockstep
from recording.files.reader import read_log
from tuning.link_and_payload.payload import PayloadEstimate, clamped_Hz, disagreement, identify_payload
from tuning.link_and_payload.tip_record import TipRecord, tip_records

POUND = 0.45359237


def _records(directory: Path, pounds: float, shaper: str, *changes: str) -> list[TipRecord]:
    loaded = load_rig("ornl_testbed")
    if not changes and loaded.rig.end_point is not None:  # without it what rings in the holds goes on ringing
        changes = ("end_point.gain=0", "servo.rotary.gain=0.35 V/deg")
    text = apply_overrides(loaded.text, [f"plant.link.payload={pounds} lb", *changes])
    request = {"maneuver": {"name": "paper_line"}, "shaper": {"kind": shaper}, "approach": True}
    (log,) = run_lockstep(LoadedRig(rig_from_text(text), text, loaded.path), [request], directory, seed=round(pounds))
    return tip_records(read_log(log))


def _without_deflection(records: list[TipRecord]) -> list[TipRecord]:
    return [replace(record, deflection=None) for record in records]


def test_clamped_frequencies_of_the_beam_equation(rig: Rig) -> None:
    """9.006, 3.145, 1.892 and 1.478 Hz at 60 in, 0.1 %."""
    assert rig.link_mode is not None
    found = [clamped_Hz(rig.link_mode, pounds * POUND, 60 * 0.0254) for pounds in (0, 15, 45, 75)]
    assert found == pytest.approx([9.006, 3.145, 1.892, 1.478], rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pounds", "shaper"),
    [
        (0, "adaptive"),
        (60, "none"),
        *(pytest.param(p, s, marks=pytest.mark.slow) for p in (0, 5, 25, 75) for s in ("none", "two_hump_ei")),
    ],
)
def test_both_ways_within_3_percent(rig: Rig, tmp_path: Path, pounds: float, shaper: str) -> None:
    """0 lb within 0.15 lb. What is stated as uncertainty holds."""
    assert rig.link_mode is not None
    records = _records(tmp_path, pounds, shaper)
    estimates = identify_payload(records, rig.link_mode)
    assert {estimate.method for estimate in estimates} == {"balance", "free vibration"}
    (alone,) = identify_payload(_without_deflection(records), rig.link_mode)
    assert alone.method == "free vibration"
    for estimate in estimates:
        assert estimate.payload_kg == pytest.approx(pounds * POUND, rel=0.03, abs=0.15 * POUND)
        assert abs(estimate.payload_kg - pounds * POUND) < 1.5 * estimate.uncertainty_kg
        assert estimate.uncertainty_kg < 0.015 * pounds * POUND + 0.06
    assert disagreement(estimates) == ""


@pytest.mark.slow
@pytest.mark.parametrize("pounds", [0, 5, 15, 45, 75])
@pytest.mark.parametrize(("maneuver", "shaper"), [("paper_line", "adaptive"), ("paper_line_y30", "none")])
def test_as_shipped_within_3_percent(rig: Rig, tmp_path: Path, maneuver: str, shaper: str, pounds: float) -> None:
    """End-point feedback on, made for 45 lb. The ringing dies too soon to be trusted alone: its stated uncertainty must say so."""
    assert rig.link_mode is not None
    text = apply_overrides(load_rig("ornl_testbed").text, [f"plant.link.payload={pounds} lb"])
    request = {"maneuver": {"name": maneuver}, "shaper": {"kind": shaper}, "approach": True}
    (log,) = run_lockstep(LoadedRig(rig_from_text(text), text, "rig"), [request], tmp_path, seed=round(pounds) + 1)
    estimates = identify_payload(tip_records(read_log(log)), rig.link_mode)
    assert estimates[0].payload_kg == pytest.approx(pounds * POUND, rel=0.03, abs=0.05 * POUND)
    for estimate in estimates:
        assert abs(estimate.payload_kg - pounds * POUND) < 1.5 * estimate.uncertainty_kg


@pytest.mark.slow
def test_with_end_point_feedback_that_damps_the_ringing(rig: Rig, tmp_path: Path) -> None:
    assert rig.link_mode is not None
    feedback = "end_point.gain=1"
    estimates = identify_payload(_records(tmp_path, 30, "none", feedback, "servo.rotary.gain=0.5 V/deg"), rig.link_mode)
    assert estimates[0].payload_kg == pytest.approx(30 * POUND, rel=0.03)


def test_a_disagreement_is_told() -> None:
    apart = [PayloadEstimate(20.0, 0.1, "balance", 1), PayloadEstimate(21.0, 0.2, "free vibration", 1)]
    assert "1.000 kg apart" in disagreement(apart)
    assert disagreement([apart[0], PayloadEstimate(20.1, 0.2, "free vibration", 1)]) == ""


def test_silence_is_refused(rig: Rig) -> None:
    assert rig.link_mode is not None
    noise = 0.02 * np.random.default_rng(1).standard_normal(8000)
    still = TipRecord(1, 0.001, noise, 1e-5 * noise, 1e-6 * noise, np.full(8000, 1.2), ((1, slice(0, 1900)),))
    with pytest.raises(LogError, match="moved too little"):
        identify_payload([still], rig.link_mode)
