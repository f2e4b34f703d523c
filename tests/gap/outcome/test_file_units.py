"""Results are shown in the units in which the rig file states its numbers; conversions by hand."""

from __future__ import annotations

import numpy as np
import pytest

from config.loading.load import load_rig
from gap.outcome.file_units import FileUnits
from gap.outcome.held_constants import FINISHED
from gap.outcome.stated_zeros import ALONE
from gap.report.headline import bars, grade, held_line, held_lines, pulled_lines, values, zero_lines

PSI_PA, INCH_M = 6894.757293168, 0.0254


@pytest.fixture(scope="module")
def units() -> FileUnits:
    """The testbed states inches, degrees, psi and pounds."""
    return FileUnits(load_rig("ornl_testbed").text)


def test_a_constant_keeps_the_unit_it_is_written_in(units: FileUnits) -> None:
    assert units.constant("plant.link.payload", "kg").text(20.41) == "45 lb"
    assert units.constant("plant.supply.pressure", "Pa").text(2000 * PSI_PA) == "2000 psi"


def test_what_belongs_to_a_joint_has_its_travels_unit_and_its_speed_too(units: FileUnits) -> None:
    assert units.channel("prismatic.position", "m").text(INCH_M) == "1 in"
    assert units.channel("prismatic.velocity", "m/s").text(10 * INCH_M) == "10 in/s"
    assert units.channel("rotary", "rad").text(np.pi / 6) == "30 deg"
    assert units.channel("sensor:rotary.position", "rad").span((0.0, np.pi)) == "0 to 180"


def test_any_other_number_has_the_unit_of_its_kind_that_the_file_uses(units: FileUnits) -> None:
    assert units.other("Pa").unit == "psi"
    assert units.other("1/furlong^7").unit == "1/furlong^7"
    assert units.other("").text(0.25) == "0.25"


def test_differences_of_temperature_have_no_offset(units: FileUnits) -> None:
    assert units.other("K").text(2.0) == "2 K"


def test_si_is_si_and_a_date_or_a_sentence_is_no_unit() -> None:
    text = "plant:\n  a: 3 bar\n  b: 2026-03-01\n  c: 16/10 mm cylinder of the lab\n"
    assert FileUnits(text, si=True).other("Pa").text(3e5) == "300000 Pa"
    assert FileUnits(text).other("Pa").text(3e5) == "3 bar"
    assert FileUnits(text).other("m").text(0.016) == "0.016 m"


@pytest.mark.parametrize(
    ("si", "stated"),
    [
        ("plant.link.payload is not the same (20.41 ± 0.45 kg in a.mcap)", "plant.link.payload is not the same (45 ± 0.9921 lb in a.mcap)"),
        ("prismatic.position: runs from 0 to 0.254 m", "prismatic.position: runs from 0 to 10 in"),
        ("return_back_pressure at supply (pressure 6.89476e+05 Pa)", "return_back_pressure at supply (pressure 100 psi)"),
        ("for 0.80 s from t = 3.000 s, 505.8 noise floors, 12 N", "for 0.80 s from t = 3.000 s, 505.8 noise floors, 12 N"),
    ],
)
def test_sentences_have_the_units_of_what_they_name(units: FileUnits, si: str, stated: str) -> None:
    assert units.sentences.text(si) == stated
    assert FileUnits(load_rig("ornl_testbed").text, si=True).sentences.text(si) == si


def test_a_changed_number_says_what_the_file_has(units: FileUnits) -> None:
    item = {"where": "prismatic", "confirmed": True, "probability": 0.99, "stated": INCH_M,
            "parameters": {"bore": {"value": 2 * INCH_M, "unit": "m", "ci95": [INCH_M, 3 * INCH_M]}}}  # fmt: skip
    assert grade(item, units) == "confirmed, probability 0.99, the file says 1 in"


def test_constants_that_the_logs_pull_are_told_with_both_numbers(units: FileUnits) -> None:
    """A data sheet's bore of 2 in, known within 3 %, at 1.8 in: 0.2 / 0.06 = 3.3 standard deviations; at 1.9 in 1.7, which is honest."""
    bore = {"value": 1.8 * INCH_M, "unit": "m", "alarm": True, "prior": {"value": 2 * INCH_M, "sd": 0.06 * INCH_M, "tag": "DS"}}
    honest = bore | {"value": 1.9 * INCH_M, "alarm": False}
    (line,) = pulled_lines({"parameters": {"plant.joints.rotary.bore": honest, "plant.joints.prismatic.bore": bore}}, units)
    values = "2 in in the rig file ([DS]), 1.8 in now, 3.3 prior standard deviations away"
    assert line == f"alarm: the logs pull plant.joints.prismatic.bore: {values}. Check that number"


def test_lines_of_the_terminal(units: FileUnits) -> None:
    deadband = {"where": "rotary", "parameters": {"gap": {"value": np.pi / 180, "unit": "rad", "ci95": [0.0, np.pi / 90]}}}
    assert values(deadband, units) == "gap 1 deg (0 to 2)"
    held = {"constant": "plant.supply.pressure", "because": "fixed", "holdout_before": 3.0, "holdout_after": 1.0,
            "wanted": {"value": 1500 * PSI_PA, "unit": "Pa", "ci95": [1400 * PSI_PA, 1600 * PSI_PA]}}  # fmt: skip
    said = "the logs want plant.supply.pressure, held by [fixed], at 1500 psi (1400 to 1600): hold-out 3 → 1 noise floors"
    assert held_line(held, units) == said
    zero = held | {"constant": "plant.supply.return_pressure", "because": "0", "line": 9,
                   "wanted": {"value": 30 * PSI_PA, "unit": "Pa", "ci95": [20 * PSI_PA, 40 * PSI_PA]}}  # fmt: skip
    told = {"held": [held | {"beside": FINISHED}, zero | {"beside": ALONE}, zero | {"beside": "return_back_pressure at supply"}]}
    alone, named = zero_lines(told, units)
    start = "plant.supply.return_pressure is 0 in the rig file (line 9); "
    assert alone.startswith(f"{start}before any name the logs want 30 psi (20 to 40): hold-out 3 → 1 noise floors. Measure it")
    assert named.startswith(f"{start}as return_back_pressure at supply the logs want 30 psi (20 to 40): hold-out 3 → 1")
    assert held_lines(told, units) == [said]
    first, second = bars({"gap": {"channels": {"rotary.position": {"before": np.pi / 180, "after": np.pi / 1800, "unit": "rad"}}}}, units)
    assert first.endswith("1 deg")
    assert second.endswith("0.1 deg")
    assert first.count("█") == 10 * second.count("█") == 30
