"""Sentences in the units of the rig file, against conversions done by hand."""

from __future__ import annotations

import pytest

from config.errors import ConfigError, ManeuverError
from config.loading.load import load_rig
from config.loading.stated_units import sentence_units
from config.stated_sentences import StatedSentences, sentences_from

TESTBED = StatedSentences(sentence_units(load_rig("ornl_testbed").text))  # psi, in, deg, g_0, mm, degC


@pytest.mark.parametrize(
    ("si", "stated"),
    [
        ("supply: 1.37895e+07 Pa (limit 1.03421e+07 to 1.65474e+07 Pa). Look.", "supply: 2000 psi (limit 1500 to 2400 psi). Look."),
        ("prismatic is at 0.9144 m, the start is 0.7620 m", "prismatic is at 36 in, the start is 30 in"),
        ("rotary position 1.6000 rad (91.67°) is above 1.5708 rad (90.00°)", "rotary position 91.67 deg is above 90 deg"),
        ("rotary position 1.5709 rad (90.01°) is above 1.5708 rad (90.00°)", "rotary position 90.01 deg is above 90 deg"),
        ("rotary rate 1.047198 rad/s, prismatic rate 0.254 m/s", "rotary rate 60 deg/s, prismatic rate 10 in/s"),
        ("the tip's acceleration is 19.6133 m/s^2", "the tip's acceleration is 2 g_0"),
        ("above interlocks.tip_acceleration_max: 39.2266 m/s^2", "above interlocks.tip_acceleration_max: 4 g_0"),
        ("tip.deflection 0.0254 m, speed 0.0254 m/s of prismatic 0.0254 m", "tip.deflection 25.4 mm, speed 25.4 mm/s of prismatic 1 in"),
        ("speed 0.127 m/s, acceleration 1.27 m/s^2", "speed 5 in/s, acceleration 50 in/s^2"),
        ("reservoir_temperature 41.5 degC", "reservoir_temperature 41.5 degC"),
        ("-0.0254 m", "-1 in"),
        ("disk space: 8.192e+06 bytes (limit ≥ 2e+08 bytes)", "disk space: 8.192 MB (limit ≥ 200 MB)"),
        ("payload 20.412 ± 0.0907 kg (rig file 20.4117 kg)", "payload 45 ± 0.2 lb (rig file 45 lb)"),
    ],
)  # fmt: skip
def test_quantities_are_converted_by_whose_they_are(si: str, stated: str) -> None:
    assert TESTBED.text(si) == stated


def test_what_stands_behind_plus_minus_is_a_difference() -> None:
    warm = StatedSentences({"oil": {"degC": ("degF", 1.8, 32.0)}})
    assert warm.text("oil at 40 ± 2 degC, 40 to 50 degC") == "oil at 104 ± 3.6 degF, 104 to 122 degF"


@pytest.mark.parametrize(
    "text",
    [
        "4 ms late, 3 of 20 overruns, 0.2 V/rad, 5 m^3/s, 2 m/s^2 rms, 12 N*m",
        "run-3.m and v1.5 m2",
        "logs/ornl-20261123-101010.mcap, cycle 12000",
        "",
    ],
)
def test_what_is_no_such_quantity_stays(text: str) -> None:
    assert TESTBED.text(text) == text


def test_a_refusal_keeps_its_class_place_and_advice() -> None:
    refusal = ManeuverError(
        "prismatic rate is too high", value="0.508", limit="0.3048", unit="m/s", where="line", next_step="At most 0.3048 m/s."
    )
    shown = TESTBED.refusal(refusal)
    assert type(shown) is ManeuverError
    assert str(shown) == "line: prismatic rate is too high: 20 in/s (limit: 12 in/s). At most 12 in/s."


def test_problems_of_a_file_stay_in_the_units_of_the_file() -> None:
    problem = ConfigError("y0 is out of range", value="0.01 m", where="line.yaml:3:1")
    assert TESTBED.refusal(problem) is problem


def test_an_older_daemon_and_a_rig_file_in_si_change_nothing() -> None:
    assert sentences_from({"units": {}}).text("prismatic 0.9144 m") == "prismatic 0.9144 m"
    assert StatedSentences({"axis": {"m": ("m", 1.0, 0.0)}}).text("axis 0.91440 m") == "axis 0.91440 m"


def test_an_offset() -> None:
    fahrenheit = StatedSentences({"oil": {"degC": ("degF", 1.8, 32.0)}})
    assert fahrenheit.text("oil 40 degC (limit 10 to 65 degC)") == "oil 104 degF (limit 50 to 149 degF)"


def test_a_value_just_above_its_limit_does_not_read_like_it() -> None:
    shown = TESTBED.refusal(ManeuverError("rotary rate is above the limit", value="1.047215", limit="1.047198", unit="rad/s"))
    assert str(shown) == "rotary rate is above the limit: 60.001 deg/s (limit: 60 deg/s)"
