"""Checks as an operator reads them: in the units of the rig file, four digits, no exponents."""

from __future__ import annotations

import math

from config.readable import number
from daemon.cli.shown.check_table import checks_lines
from daemon.server.stated_values import as_stated

PRESSURE = {"name": "supply limit", "ok": True, "value": 13.74e6, "limit": "1.03421e+07 to 1.65474e+07", "unit": "Pa", "source": "plant"}
PSI = {"supply limit": ("psi", 1.0 / 6894.757293168, 0.0)}


def test_value_and_both_limits_are_converted() -> None:
    shown = as_stated(PRESSURE, PSI)
    assert number(shown["value"]) == "1993"
    assert shown["limit"] == "1500 to 2400"
    assert "1993 psi  (limit 1500 to 2400)" in checks_lines([PRESSURE], PSI)[0]


def test_without_a_stated_unit_nothing_changes() -> None:
    assert as_stated(PRESSURE, {}) == PRESSURE


def test_an_offset_and_a_negative_limit() -> None:
    check = {"name": "oil", "ok": True, "value": 40.0, "limit": "≥ -10", "unit": "degC", "source": "plant"}
    shown = as_stated(check, {"oil": ("degF", 1.8, 32.0)})
    assert number(shown["value"]) == "104"
    assert shown["limit"] == "≥ 14"


def test_numbers_are_read_without_exponents_and_nothing_breaks_on_no_value() -> None:
    assert [number(value) for value in (67570.0, 0.012345, None, 3, math.nan)] == ["67570", "0.01235", "no value", "3", "nan"]
