from __future__ import annotations

from math import inf, nan

import pytest

from config.loading.load import load_rig
from daemon.checks.checks import Check, CheckGroup, Reaction
from daemon.checks.interlocks import interlocks, rig_facts
from daemon.cycle.facts import Facts


def checks_of(name: str) -> tuple[tuple[Check, ...], Facts]:
    rig = load_rig(name).rig
    facts = rig_facts(rig)
    return interlocks(rig, facts), facts


@pytest.mark.parametrize("name", ["ornl_testbed", "force_axis"])
def test_every_check_has_a_name_of_its_own_a_source_and_advice(name: str) -> None:
    checks, _ = checks_of(name)
    assert len({check.name for check in checks}) == len(checks)
    for check in checks:
        assert check.source
        assert check.next_step.endswith(".")
        assert check.low <= check.high


def test_what_the_rig_file_limits_is_checked_and_what_it_does_not_is_not() -> None:
    ornl, _ = checks_of("ornl_testbed")
    names = {check.name for check in ornl}
    assert {"e-stop", "rotary.position quality", "rotary.position age", "rotary.position range"} <= names
    assert {
        "rotary.supply_pressure limit",
        "prismatic.return_pressure limit",
        "reservoir_temperature limit",
        "tip.acceleration limit",
    } <= names
    assert {"rotary following error", "prismatic travel", "loop timing", "loop stall", "recorder lost", "disk space"} <= names
    assert not any("tip.deflection" in name for name in names), "not required"
    force, _ = checks_of("force_axis")
    assert not any("pressure" in check.name for check in force)


def test_limits_include_their_ends_and_exclude_no_number() -> None:
    check = Check("x", 0, 1.0, 2.0, "Pa", "dev.ch", Reaction.STOP, "Do this.")
    assert [check.passes([value]) for value in (0.999, 1.0, 2.0, 2.001, nan, inf)] == [False, True, True, False, False, False]


def test_a_refusal_says_what_value_limit_unit_source_and_what_to_do() -> None:
    check = Check("oil", 0, -inf, 65.0, "degC", "plant.t", Reaction.STOP, "Check the cooler.")
    assert check.sentence([70.25]) == "oil (plant.t): 70.25 degC (limit ≤ 65 degC). Check the cooler."
    assert "no valid value" in check.sentence([nan])
    row = check.row([70.25])
    assert (row["ok"], row["value"], row["limit"], row["unit"], row["source"]) == (False, 70.25, "≤ 65", "degC", "plant.t")


def test_a_group_finds_the_first_failed_check_in_order() -> None:
    first = Check("a", 0, 0, 1, "", "s", Reaction.FAULT, "A.")
    second = Check("b", 1, 0, 1, "", "s", Reaction.FAULT, "B.")
    group = CheckGroup([first, second])
    assert group.first_failed([0.5, 0.5]) is None
    assert group.first_failed([0.5, 2.0]) is second
    assert group.first_failed([2.0, 2.0]) is first
    assert group.first_failed([nan, 0.5]) is first


def test_before_anything_was_measured_nothing_can_be_armed() -> None:
    checks, facts = checks_of("ornl_testbed")
    values = facts.blank()
    failed = {check.name for check in checks if not check.passes(values)}
    assert {f"{name} quality" for name in ("rotary.position", "prismatic.position", "tip.acceleration")} <= failed
