"""Values in the units of the rig file, against conversion factors from their definitions."""

from __future__ import annotations

import math

import pytest

from config.loading.load import load_rig
from config.loading.stated_units import conversion, conversions, stated_units


@pytest.mark.parametrize(
    ("si", "unit", "stated", "shown"),
    [
        (6894.757293168, "Pa", "psi", 1.0),
        (1e5, "Pa", "bar", 1.0),
        (0.0254, "m", "in", 1.0),
        (100.0, "degC", "degF", 212.0),
        (math.pi, "rad/s", "deg", 180.0),  # a rate of what is stated in degrees
        (9.80665, "m/s^2", "g_0", 1.0),
    ],
)
def test_a_value_is_shown_in_the_stated_unit(si: float, unit: str, stated: str, shown: float) -> None:
    found = conversion(unit, stated)
    assert found is not None
    _, factor, offset = found
    assert factor * si + offset == pytest.approx(shown, rel=1e-9)


def test_what_is_of_another_kind_stays_as_it_is() -> None:
    assert conversion("s", "psi") is None
    assert conversion("days left", "psi") is None
    assert conversions({"e-stop": "", "rotary.supply_pressure age": "s"}, {"rotary.supply_pressure": "psi"}) == {}


def test_the_testbed_is_read_in_its_own_units() -> None:
    stated = stated_units(load_rig("ornl_testbed").text)
    assert stated["rotary.supply_pressure"] == "psi"
    assert stated["tip.deflection"] == "mm"
    assert stated["prismatic"] == "in"
    assert stated["rotary"] == "deg"
