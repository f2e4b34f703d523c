"""What is followed on shipped rigs, under which names, how far it may move, and where its limits are."""

from __future__ import annotations

import math

import pytest

from config.errors import UsageError
from config.loading.load import LoadedRig, load_rig
from gap.fitting.nuisance import nuisances
from gap.outcome.file_units import FileUnits
from gap.watch.limits import NumberLimits, limits_of
from gap.watch.watched import Watched, watched, with_wide_priors


def of(loaded: LoadedRig) -> list[Watched]:
    return watched(loaded.rig, nuisances(loaded, frozenset()))


@pytest.fixture(scope="module")
def cylinder() -> LoadedRig:
    return load_rig("analogue_axis")


def test_friction_leakage_valve_and_oil_of_a_cylinder_are_followed(cylinder: LoadedRig) -> None:
    assert {number.name for number in of(cylinder)} == {
        "axis.coulomb_friction.friction", "axis.stiction.excess", "axis.viscous_friction.coefficient", "axis.valve_lag.time_constant",
        "axis.cross_leakage.conductance", "axis.rated_flow", "oil.bulk_modulus",
    }  # fmt: skip


def test_a_fit_may_go_where_wear_goes_and_other_constants_keep_their_priors(cylinder: LoadedRig) -> None:
    free = nuisances(cylinder, frozenset())
    numbers = watched(cylinder.rig, free)
    for number in numbers:
        assert number.wide.scale == pytest.approx(0.5 * number.free.start)
        assert number.wide.low <= number.free.low < number.free.high <= number.wide.high
    leak = next(number for number in numbers if number.name == "axis.cross_leakage.conductance")
    assert (leak.wide.low, leak.wide.high > 10 * leak.free.start) == (0.0, True)
    followed = {number.free.key for number in numbers}
    wide = with_wide_priors(free, numbers)
    assert [item for item in wide if item.key not in followed] == [item for item in free if item.key not in followed]


def test_limits_are_three_standard_deviations_of_the_tag(cylinder: LoadedRig) -> None:
    """[C] is 20 %; a bound on the other side of 0 is none."""
    found = limits_of(of(cylinder), [], FileUnits(cylinder.text))
    friction = found["axis.coulomb_friction.friction"]
    assert (friction.low, friction.high) == (pytest.approx(0.4 * 321.6), pytest.approx(1.6 * 321.6))
    assert all(limit.low > 0.0 and math.isfinite(limit.high) for limit in found.values())


def test_limits_are_given_in_any_unit_and_bare_in_that_of_the_file(cylinder: LoadedRig) -> None:
    asked = ["axis.rated_flow=15 lpm", "axis.rated_flow=25", "oil.bulk_modulus=0.9", "axis.coulomb_friction.friction=0.5 kN"]
    found = limits_of(of(cylinder), asked, FileUnits(cylinder.text))
    flow, modulus, friction = (found[asked.partition("=")[0]] for asked in asked[1:])
    assert (flow.low, flow.high) == (pytest.approx(15e-3 / 60), pytest.approx(25e-3 / 60))
    own = limits_of(of(cylinder), [], FileUnits(cylinder.text))
    assert modulus == NumberLimits(pytest.approx(0.9e9), own["oil.bulk_modulus"].high), "what is not asked for stays"
    assert friction == NumberLimits(own["axis.coulomb_friction.friction"].low, 500.0)


def test_a_limit_in_a_wrong_unit_names_the_option(cylinder: LoadedRig) -> None:
    with pytest.raises(UsageError, match="wrong kind of unit") as refused:
        limits_of(of(cylinder), ["axis.rated_flow=17 mm"], FileUnits(cylinder.text))
    assert refused.value.refusal.where == "--limit"


@pytest.mark.parametrize(
    ("asked", "what"),
    [
        (["axis.coulomb_friction.friction=321.6 N"], "neither an upper nor a lower one"),
        (["axis.coulomb_friction.friction=-5 N"], "never has the other sign"),
        (["axis.coulomb_friction.friction=400 N", "axis.coulomb_friction.friction=0.6 kN"], "the upper limit of .* is given twice"),
    ],
)
def test_what_limits_nothing_and_a_second_limit_of_one_side_are_refused(asked: list[str], what: str, cylinder: LoadedRig) -> None:
    with pytest.raises(UsageError, match=what) as refused:
        limits_of(of(cylinder), asked, FileUnits(cylinder.text))
    assert refused.value.refusal.value == asked[-1]


@pytest.mark.parametrize("asked", ["axis.rated_flows=15 lpm", "axis.rated_flow", "plant.joints.axis.mass=3 kg"])
def test_a_limit_of_something_else_is_refused(asked: str, cylinder: LoadedRig) -> None:
    with pytest.raises(UsageError, match="no number of this name is followed: "):
        limits_of(of(cylinder), [asked], FileUnits(cylinder.text))


def test_the_bias_of_a_null_may_be_limited_on_the_other_side_of_0() -> None:
    axis = load_rig("force_axis")
    found = limits_of(of(axis), ["axis.valve_null_bias.bias=0.02"], FileUnits(axis.text))["axis.valve_null_bias.bias"]
    assert found.low < -0.009 < found.high == 0.02
