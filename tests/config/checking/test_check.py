"""`longreach check` without hardware: what is found, against numbers of the paper and closed forms."""

from __future__ import annotations

import datetime
import math
import re
from pathlib import Path

import pytest
from scipy.optimize import brentq

import config
from config.checking.check import check_rig, feasible_y0, link_frequency_estimate_Hz
from config.checking.finding import Finding
from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text
from tests.support.config.small_rig import SMALL, changed

TODAY = datetime.date(2026, 1, 1)
INCH_M = 0.0254
PLACE = re.compile(r"^bench.yaml:\d+:\d+: ")


def findings(text: str, today: datetime.date = TODAY) -> list[Finding]:
    return check_rig(LoadedRig(rig_from_text(text), text, "bench.yaml"), today)


def complaints(text: str) -> list[str]:
    """Without the place, which is asserted to be a line of the file."""
    found = [finding.text for finding in findings(text) if finding.level != "ok"]
    return [PLACE.sub("", each) for each in found]


@pytest.mark.parametrize("name", sorted(path.stem for path in (Path(config.__file__).parent / "rigs").glob("*.yaml")))
def test_the_shipped_rigs_have_no_errors_and_no_chamber_runs_empty(name: str) -> None:
    found = check_rig(load_rig(name), TODAY)
    assert [finding for finding in found if finding.level == "error" or "the chamber is empty" in finding.text] == []


def test_the_line_of_the_paper_fits_from_12_to_51_96_in() -> None:
    rig = load_rig("ornl_testbed").rig
    allowed = feasible_y0(rig, 30 * INCH_M)
    assert allowed is not None
    assert [bound / INCH_M for bound in allowed] == pytest.approx([12, math.sqrt(60**2 - 30**2)])
    texts = [finding.text for finding in check_rig(load_rig("ornl_testbed"), TODAY)]
    assert "straight lines from x = -30 in to +30 in: y0 from 12.00 to 51.96 in fits into the joints' travel" in texts


def test_the_rotary_travel_can_be_what_limits_the_line() -> None:
    text = apply_overrides(load_rig("ornl_testbed").text, ["joints.rotary.travel=[-45 deg, 50 deg]"])
    allowed = feasible_y0(rig_from_text(text), 30 * INCH_M)
    assert allowed is not None
    assert allowed[0] / INCH_M == pytest.approx(30)  # 45 deg at x = 30 in
    assert feasible_y0(rig_from_text(text), 61 * INCH_M) is None


@pytest.mark.parametrize("extension_in", [12, 20, 30, 42.4, 60])
@pytest.mark.parametrize("payload_lb", [0, 15, 45, 75])
def test_the_estimated_link_frequency_lies_just_above_the_exact_one(extension_in: float, payload_lb: float) -> None:
    """Rayleigh's quotient bounds the first frequency from above; the exact one solves the clamped beam with a tip mass."""
    text = apply_overrides(load_rig("ornl_testbed").text, [f"link_mode.payload={payload_lb} lb"])
    rig = rig_from_text(text)
    link = rig.link_mode
    assert link is not None
    length_m = extension_in * INCH_M
    ratio = link.payload_kg / (link.mass_per_length_kg_per_m * length_m)

    def characteristic(k: float) -> float:
        return 1 + math.cos(k) * math.cosh(k) + ratio * k * (math.cos(k) * math.sinh(k) - math.sin(k) * math.cosh(k))

    k = brentq(characteristic, 1e-3, 1.8752)
    exact_Hz = k**2 / (2 * math.pi) * math.sqrt(link.bending_stiffness_N_m2 / (link.mass_per_length_kg_per_m * length_m**4))
    assert 1.0 - 1e-9 <= link_frequency_estimate_Hz(rig, length_m) / exact_Hz < 1.016


def test_plausibility_range_inside_the_travel() -> None:
    assert "axis.position: high = 1.016 m lies inside the travel, which ends at 1.2192 m" in complaints(changed(("49 in", "40 in")))
    assert "axis.position: low = 0.0254 m lies inside the travel, which ends at 0 m" in complaints(changed(("-1 in", "1 in")))


def test_age_shorter_than_a_period() -> None:
    text = apply_overrides(SMALL, ["signals.axis.position.max_age=1 ms"])
    assert "axis.position: max_age 0.001 s is less than one period of the loop, 0.002 s: always stale" in complaints(text)


def test_command_too_small_for_the_rate() -> None:
    text = apply_overrides(SMALL, ["servo.axis.velocity_feedforward=2 V*s/in"])
    assert any("rate_limit needs 20 V by the feed-forward, command_limit is 10 V" in text for text in complaints(text))


def test_a_calibration_past_its_day() -> None:
    text = apply_overrides(SMALL, ["signals.axis.position.calibration.valid_until=2025-12-31"])
    assert "axis.position: the calibration was valid until 2025-12-31: calibrate again" in complaints(text)
    before = [finding.text for finding in findings(text, datetime.date(2025, 12, 31))]
    assert not any("calibrate again" in text for text in before)


def test_a_calibration_past_its_day_that_blocks_is_an_error() -> None:
    record = "signals.axis.position.calibration"
    text = apply_overrides(SMALL, [f"{record}.valid_until=2025-12-31", f"{record}.on_expiry=block"])
    (found,) = [finding for finding in findings(text) if "calibrate again" in finding.text]
    assert found.level == "error"
    assert "cannot be armed" in found.text


def test_a_block_without_a_day_and_a_day_to_come_are_pointed_out() -> None:
    record = "signals.axis.position.calibration"
    never = findings(apply_overrides(SMALL, [f"{record}.on_expiry=block"]))
    assert any("on_expiry: block never blocks without valid_until" in finding.text for finding in never)
    early = findings(apply_overrides(SMALL, [f"{record}.calibrated_on=2030-01-01"]), datetime.date(2029, 12, 31))
    assert any("calibrated_on 2030-01-01 has not come yet" in finding.text for finding in early)


def test_a_proof_that_is_not_demanded_is_pointed_out() -> None:
    text = apply_overrides(load_rig("ornl_testbed_can").text, ["devices.rotary_valve.demand_proof=false"])
    assert any("devices.rotary_valve: demand_proof is false" in complaint for complaint in complaints(text))
    assert not any("demand_proof" in complaint for complaint in complaints(load_rig("ornl_testbed_can").text))


def test_a_measured_pressure_without_a_limit() -> None:
    text = changed(("interlocks:\n  supply_pressure_min: 1500 psi\n", ""))
    assert any("interlocks.supply_pressure_min is not set" in complaint for complaint in complaints(text))


def test_maneuvers_are_offered_to_the_arm_that_has_their_joints() -> None:
    last = findings(SMALL)[-1].text
    assert last.startswith("shipped maneuvers for this arm: hold; for other arms: ")
    assert "paper_line" in last


def test_a_line_outside_the_travel_is_told_with_what_would_fit() -> None:
    text = apply_overrides(load_rig("ornl_testbed").text, ["joints.prismatic.travel.1=49 in"])
    assert (
        "maneuver paper_line: the line to x = ±30 in has y0 = 40 in; y0 from 12.00 to 38.74 in fits into the joints' travel"
        in complaints(text)
    )
