"""The choice of the next maneuver: the same as trying all, and honest where none or only a sensor helps."""

from __future__ import annotations

import axis_logs
import numpy as np
import pytest

from config.errors import LongreachError
from config.load import LoadedRig, load_rig
from config.shipped import shipped
from gap.closed_loop import measured_on, planned
from gap.designs import Design, designs
from gap.extra_sensor import extra_sensors, with_sensors
from gap.matching import matched
from gap.next_maneuver import Proposal, next_maneuver, no_effect, rival_of
from gap.separation import Rival, compare


def quiet(line: str) -> None:
    """No progress."""


def axis(*without: str) -> LoadedRig:
    return LoadedRig(axis_logs.axis_rig(*without), axis_logs.axis_text(*without), "axis.yaml")


def rivals(loaded: LoadedRig) -> tuple[Rival, Rival]:
    coulomb = rival_of(loaded, "coulomb_friction", "axis", {"friction": 0.5})
    return coulomb, rival_of(loaded, "valve_deadband", "axis", {"overlap": 0.0014})


@pytest.mark.parametrize("name", ["ornl_testbed", "force_axis"])
def test_every_form_can_be_planned(name: str) -> None:
    """Inside travel, rate, acceleration and volts; planning refuses what is not."""
    rig = load_rig(name).rig
    forms = [d for d in designs(rig, list(rig.joints)) if d.parameters]
    assert len(forms) >= 10 * len(rig.joints)
    for design in forms:
        assert planned(rig, design.content).duration_s > 5.0, design.label


def test_every_shipped_maneuver_takes_part() -> None:
    rig = load_rig("ornl_testbed").rig
    assert {d.name for d in designs(rig, list(rig.joints)) if not d.parameters} == set(shipped("maneuvers"))


def test_half_the_wave_again_until_it_is_small() -> None:
    design: Design | None = Design("multisine", {"amplitude": "1 V"})
    sizes = []
    while design is not None:
        sizes.append(design.parameters["amplitude"])
        design = design.smaller
    assert sizes == ["1 V", "0.5 V", "0.25 V", "0.125 V", "0.0625 V"]
    assert Design("jog").smaller is None


@pytest.mark.slow
def test_the_best_first_search_finds_what_trying_all_finds() -> None:
    loaded = axis("coulomb_friction")
    first, second = rivals(loaded)
    found = next_maneuver(loaded, first, second, quiet)
    assert found is not None
    tried = []
    for design in designs(loaded.rig, ["axis"], thorough=False):
        try:
            comparison = compare(loaded, first, second, design.content)
            measured_on(second.model.fitted_rig(), design.content)  # either may be the truth, so both must bear it
        except LongreachError:
            continue
        tried.append(Proposal(design, ("", ""), comparison.exact(), comparison.log.duration_s))
    best = min(tried, key=lambda p: (p.time_s, -p.separation.t))
    assert found.time_s == pytest.approx(best.time_s)
    assert found.design == best.design


def test_two_constant_forces_are_told_apart_by_nothing() -> None:
    loaded = axis("valve_null_bias")
    tilt = -0.01 * 351.507 / (95.1089 * 9.80665)  # the same force as a hundredth of the drive's
    pair = rival_of(loaded, "valve_null_bias", "axis", {"bias": 0.01}), rival_of(loaded, "gravity", "axis", {"tilt": tilt})
    found = next_maneuver(loaded, *pair, quiet)
    assert found is not None
    assert found.repeats is None
    assert found.sensor == ()
    assert "no maneuver" in found.why
    assert found.as_dict()["repeats"] is None


def test_rivals_from_no_fit_are_made_alike_first() -> None:
    """At their typical sizes the two forces differ in size and sign; matched, only their names differ."""
    loaded = axis("valve_null_bias")
    bias, tilt = rival_of(loaded, "valve_null_bias", "axis"), rival_of(loaded, "gravity", "axis")
    found = matched(loaded, bias, tilt, designs(loaded.rig, ["axis"], thorough=False))
    force = 351.507 * bias.model.theta[-1]
    assert 95.1089 * 9.80665 * np.sin(found.model.theta[-1]) == pytest.approx(-force, rel=0.02)


def test_a_sensor_the_rig_lacks_can_be_tried() -> None:
    loaded = load_rig("ornl_testbed")
    rig = loaded.rig
    assert rig.plant is not None
    fitted = list(rig.plant.sensors)
    extras = extra_sensors(rig, fitted)
    assert {c for extra in extras for c in extra.channels} == {f"{j}.pressure_{c}" for j in rig.joints for c in "ab"}
    grown = with_sensors(no_effect(loaded).model, extras).rig.plant
    assert grown is not None
    assert list(grown.sensors)[: len(fitted)] == fitted
    assert grown.sensors["rotary.pressure_a"].noise == rig.plant.sensors["rotary.supply_pressure"].noise
    assert [e.channels for e in extra_sensors(rig, [c for c in fitted if not c.startswith("tip.")])][-2:] == [
        ("tip.deflection",),
        ("tip.acceleration",),
    ]
