"""The choice of the next maneuver: the same as trying all, and honest where none or only a sensor helps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from config.errors import LongreachError
from config.loading.load import LoadedRig, load_rig
from config.loading.shipped import shipped
from daemon.cli.gap.gap_next import advice
from gap.maneuvers.closed_loop import planned
from gap.maneuvers.designs import ManeuverDesign, designs
from gap.maneuvers.extra_sensor import ExtraSensor, extra_sensors, with_sensors
from gap.maneuvers.matching import matched
from gap.maneuvers.next_maneuver import _Course, next_maneuver
from gap.maneuvers.proposal import LEAST_SEPARATION, Pair, Proposal
from gap.maneuvers.rivals import no_effect, rival_of
from gap.maneuvers.separation import Rival, Separation
from sim_backend.kernel.batch import quiet as quiet_sensors
from sim_backend.memory.layout import MAX_SENSORS
from sim_backend.plant import SimulatedRig
from tests.support.gap import axis_logs
from tests.support.gap.compared import compare


def quiet(line: str) -> None:
    """No progress."""


def axis(*without: str) -> LoadedRig:
    return LoadedRig(axis_logs.axis_rig(*without), axis_logs.axis_text(*without), "axis.yaml")


def rivals(loaded: LoadedRig) -> tuple[Rival, Rival]:
    coulomb = rival_of(loaded, "coulomb_friction", "axis", {"friction": 0.5})
    return coulomb, rival_of(loaded, "valve_deadband", "axis", {"overlap": 0.0014})


@pytest.mark.slow
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


def test_half_the_power_again_until_the_wave_is_small() -> None:
    design: ManeuverDesign | None = ManeuverDesign("multisine", {"amplitude": "1 V"})
    sizes = []
    while design is not None:
        sizes.append(design.parameters["amplitude"])
        design = design.smaller
    assert sizes == ["1 V", "0.707 V", "0.5 V", "0.354 V", "0.25 V", "0.177 V", "0.125 V", "0.0884 V"]
    assert ManeuverDesign("jog").smaller is None


@pytest.mark.slow
def test_the_best_first_search_finds_what_trying_all_finds() -> None:
    loaded = axis("coulomb_friction")
    first, second = rivals(loaded)
    found = next_maneuver(loaded, [first, second], quiet)
    assert found is not None
    tried = []
    for design in designs(loaded.rig, ["axis"], thorough=False):
        try:
            ways = [compare(loaded, *pair, design.content) for pair in ((first, second), (second, first))]
        except LongreachError:
            continue  # either may be the truth, so both must bear it
        alike = [way.run.alike(way.rival) for way in ways]
        separation = alike[0].bound().or_less(alike[0].exact()).or_less(alike[1].exact()).or_less(ways[0].exact())
        tried.append(Proposal(design, (Pair(("", ""), separation),), ways[0].log.duration_s))
    best = min(tried, key=lambda p: p.rank)
    assert found.time_s == pytest.approx(best.time_s)
    assert found.design == best.design


@pytest.mark.slow
def test_two_constant_forces_are_told_apart_by_nothing() -> None:
    loaded = axis("valve_null_bias")
    tilt = -0.01 * 351.507 / (95.1089 * 9.80665)  # the same force as a hundredth of the drive's
    pair = rival_of(loaded, "valve_null_bias", "axis", {"bias": 0.01}), rival_of(loaded, "gravity", "axis", {"tilt": tilt})
    found = next_maneuver(loaded, pair, quiet)
    assert found is not None
    assert found.repeats is None
    assert found.sensor is None
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
    pressures, second = {f"{j}.pressure_{c}" for j in rig.joints for c in "ab"}, {f"{j}.second_position" for j in rig.joints}
    assert {c for extra in extras for c in extra.channels} == pressures | second
    grown = with_sensors(no_effect(loaded).model, extras).rig.plant
    assert grown is not None
    assert {name for name in fitted if "_temperature" not in name} <= set(grown.sensors)
    assert len(grown.sensors) <= MAX_SENSORS
    assert grown.sensors["rotary.pressure_a"].noise == rig.plant.sensors["rotary.supply_pressure"].noise
    assert [e.channels for e in extra_sensors(rig, [c for c in fitted if not c.startswith("tip.")])][-4:-2] == [
        ("tip.deflection",),
        ("tip.acceleration",),
    ]


def late(loaded: LoadedRig) -> list[Rival]:
    """A late command and a late encoder: on a rig that measures the position alone they are exactly the same."""
    return [
        rival_of(loaded, "transport_delay", "axis", {"delay": 0.004}),
        rival_of(loaded, "sensor_delay", "sensor:axis.position", {"delay": 0.004}),
    ]


def test_a_second_sensor_of_the_same_motion_sees_what_the_first_sees_but_not_its_delay() -> None:
    """Commands of nothing but time: the sensor that is late shows what the other one showed 4 ms before."""
    extra = ExtraSensor(("axis.second_position",))
    rig = with_sensors(late(axis())[1].model, [extra]).fitted_rig()
    plant = SimulatedRig(rig)
    plant.parameters.values[:] = quiet_sensors(plant.parameters)
    plant.reset([0.12])
    raw = plant.run(np.sin(np.arange(400) / 30.0)[:, None], 0.001, sense=True)["raw"]
    second, first = (raw[:, plant.channels.index(name)] for name in ("axis.second_position", "axis.position"))
    assert np.ptp(second) > 100
    np.testing.assert_allclose(first[4:], second[:-4], atol=1e-3)


@pytest.mark.slow
def test_a_late_command_and_a_late_encoder_need_another_sensor() -> None:
    """Two of the maneuvers are enough to see it; the search itself looks at all."""
    loaded = axis()
    course = _Course(
        loaded,
        [replace(r, model=with_sensors(r.model, extra_sensors(loaded.rig, ["axis.position"]))) for r in late(loaded)],
        ("axis.position",),
        extra_sensors(loaded.rig, ["axis.position"]),
        quiet,
    )
    forms = designs(loaded.rig, ["axis"], thorough=False)
    wave = next(d for d in forms if d.parameters.get("amplitude") == "2 V" and d.parameters.get("from") == "2 Hz")
    found = course.soonest([wave, next(d for d in forms if d.name == "fast_strokes")])
    assert found is not None
    assert found.repeats is None
    assert max(pair.separation.T for pair in found.pairs) < LEAST_SEPARATION
    asked = course.best_sensor(found)
    assert asked.as_dict()["sensor"] == ["axis.second_position"]
    assert asked.repeats == 1
    assert "only another sensor separates the two: with a second position sensor of axis" in asked.why


@pytest.mark.slow
def test_of_three_all_that_can_be_told_apart_are_and_the_rest_is_said() -> None:
    loaded = axis()
    rivals = [*late(loaded), rival_of(loaded, "valve_lag", "axis", {"time_constant": 0.002, "damping_ratio": 1.0})]
    found = next_maneuver(loaded, rivals, quiet)
    assert found is not None
    content = found.as_dict()
    assert content["repeats"] == 1
    assert content["sensor"] is None
    assert content["separates"] == ["transport_delay at axis", "valve_lag at axis", "sensor_delay at sensor:axis.position"]
    told = {tuple(pair["between"]): pair["expected_t"] for pair in content["pairs"] if pair["repeats"]}
    assert len(told) == 2
    assert content["expected_t"] == min(told.values()) > 5.0
    assert "leaves open transport_delay at axis or sensor_delay at sensor:axis.position" in found.why
    assert advice(content).count("not told apart") == 1


def test_the_slowest_pair_decides_and_fewer_open_pairs_go_first() -> None:
    """By hand: repeats are (5 / t)² rounded up, and the time is the slowest pair's."""
    told = [Separation(500.0, 7.0), Separation(100.0, 2.0), Separation(1.0, 4.0)]
    names = [("a", "b"), ("a", "c"), ("b", "c")]
    pairs = tuple(Pair(n, s) for n, s in zip(names, told, strict=True))
    found = Proposal(ManeuverDesign("jog"), pairs, 10.0)
    assert [pair.repeats for pair in found.pairs] == [1, 7, None]
    assert (found.repeats, found.time_s, found.least.t) == (7, 70.0, 2.0)
    quick = Proposal(ManeuverDesign("jog"), (pairs[0], pairs[2], pairs[2]), 1.0)
    assert found.rank < quick.rank
    assert quick.as_dict()["separates"] == ["a", "b"]
