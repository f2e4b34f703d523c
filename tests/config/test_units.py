"""Unit conversion against factors that are defined exactly, and round trips."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from config.errors import UnitError
from config.schema.section import yaml_key
from config.units import from_si, to_si, written_unit

POUND_KG, INCH_M, STANDARD_GRAVITY = 0.45359237, 0.0254, 9.80665
PSI_PA = POUND_KG * STANDARD_GRAVITY / INCH_M**2

EXACT = [
    ("2000 psi", "Pa", 2000 * PSI_PA),
    ("30 in", "m", 30 * INCH_M),
    ("100 in/s^2", "m/s^2", 100 * INCH_M),
    ("45 lb", "kg", 45 * POUND_KG),
    ("0.35 V/deg", "V/rad", 0.35 * 180 / math.pi),
    ("0.0232 V*s/deg", "V*s/rad", 0.0232 * 180 / math.pi),
    ("2 mg_0", "m/s^2", 0.002 * STANDARD_GRAVITY),
    ("15 gpm", "m^3/s", 15 * 231 * INCH_M**3 / 60),
    ("6 lpm", "m^3/s", 1e-4),
    ("43 cSt", "m^2/s", 43e-6),
    ("10 in^3/rad", "m^3/rad", 10 * INCH_M**3),
    ("60 rpm", "rad/s", 2 * math.pi),
    ("5 turn/s", "rad/s", 10 * math.pi),
    ("15 arcmin", "rad", 15 / 60 * math.pi / 180),
    ("4 mrad", "rad", 0.004),
    ("41 °F", "degC", 5.0),
    ("-0.35 %/K", "1/K", -0.0035),
    ("0.1 degC", "K", 0.1),
    ("0.18 degF", "K", 0.1),
    ("2 %", "", 0.02),
    ("200 MB", "bytes", 2e8),
    ("2 GiB", "bytes", 2.0**31),
    ("500 kbit/s", "bit/s", 5e5),
    ("1e-3 m", "m", 1e-3),
    ("  .5 m ", "m", 0.5),
    (7, "m", 7.0),
    ("7", "m", 7.0),
]


@pytest.mark.parametrize(("written", "unit", "value"), EXACT)
def test_values_agree_with_the_definitions_of_the_units(written: str | float, unit: str, value: float) -> None:
    assert to_si(written, unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("written", "unit"),
    [
        ("5 Hz", "rad/s"),  # a corner frequency: 5 Hz is 31.4 rad/s, not 5
        ("0.35 V", "V/rad"),
        ("300 rad/s", "Hz"),
        ("10 %", "bytes"),  # a share of a disk, which was 0.0125 bytes
        ("3 bytes", ""),
        ("500 kHz", "bit/s"),
        ("-6 dB", ""),  # a gain of -6, or of 0.5, or 0.25
        ("3 dBm", "W"),
        ("5 mil", "rad"),  # 1/6400 of a turn to NATO, 1/64000 to pint
        ("5 mil/s", "rad/s"),
        ("2000 kg", "Pa"),
        ("30", "nonsense_unit_of_ours and more"),
        ("2000 psii", "Pa"),
        ("psi", "Pa"),
        ("1 2", "Pa"),
        ("1 m; import os", "m"),
        ("nan", "m"),
        (float("nan"), "m"),
        (float("inf"), "m"),
        ("1e999 m", "m"),
        (True, "m"),
    ],
)
def test_what_is_no_quantity_of_the_unit_is_refused(written: str | float, unit: str) -> None:
    if written == "30":
        assert to_si(written, unit) == 30.0  # a bare number is never converted, so the unit is not looked at
        return
    with pytest.raises(UnitError):
        to_si(written, unit)


def test_true_is_refused_though_python_holds_it_equal_to_one() -> None:
    assert to_si(1, "m") == 1.0
    with pytest.raises(UnitError, match="a number was expected: True m"):
        to_si(True, "m")


@pytest.mark.parametrize(("unit", "wanted"), [("Pa", "psi"), ("m", "in"), ("degC", "degF"), ("rad", "deg"), ("kg", "lb"), ("m^3/s", "gpm")])
@given(value=st.floats(min_value=-1e9, max_value=1e9))
def test_round_trips(unit: str, wanted: str, value: float) -> None:
    shown = from_si(value, unit, wanted)
    assert to_si(f"{shown!r} {wanted}", unit) == pytest.approx(value, rel=1e-9, abs=1e-9)


def test_written_unit() -> None:
    assert [written_unit(text) for text in ("2000 psi", "5", 5, "0.35 V/deg", None)] == ["psi", "", "", "V/deg", ""]


@pytest.mark.parametrize(
    ("field", "key"),
    [
        ("supply_pressure_Pa", "supply_pressure"),
        ("stiffness_N_per_m", "stiffness"),
        ("mass_per_length_kg_per_m", "mass_per_length"),
        ("bending_stiffness_N_m2", "bending_stiffness"),
        ("speed_m_per_s", "speed"),
        ("acceleration_m_per_s2", "acceleration"),
        ("volume_m3", "volume"),
        ("gain_N_m_per_V", "gain"),
        ("specific_heat_J_per_kg_K", "specific_heat"),
        ("inertia_kg_m2", "inertia"),
        ("rate_limit", "rate_limit"),
        ("name", "name"),
    ],
)
def test_keys_are_field_names_without_their_unit(field: str, key: str) -> None:
    assert yaml_key(field) == key
