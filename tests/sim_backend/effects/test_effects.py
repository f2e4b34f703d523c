"""Every effect: found, without influence when absent or neutral, of influence when not, and told apart from others."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from config.schema.effect import Case
from config.schema.effect_entry import unit_at
from config.schema.effect_library import EFFECTS
from sim_backend.memory.layout import C
from tests.support.sim_backend.plants import Content, SimulatedRig, ornl, variant, with_effects

NAMES = """
coulomb_friction stiction viscous_friction asymmetric_friction pressure_friction backlash inertia_error gravity
valve_deadband valve_hysteresis valve_null_bias valve_saturation valve_lag valve_flow_asymmetry transport_delay
cross_leakage external_leakage bulk_modulus_temperature entrained_air hose_compliance
supply_droop return_back_pressure line_loss
link_flexibility payload_error link_damping_error
sensor_delay sensor_scale sensor_offset sensor_polarity sensor_quantization
unnamed_remainder
"""
ROTARY = "rotary"
CASES = [(name, case) for name, effect in EFFECTS.items() for case in effect.cases]
IDS = [f"{name} at {case.where}" for name, case in CASES]


def warm(content: Content) -> None:
    content["plant"]["oil"]["initial_temperature"] = "45 degC"


def deleted(name: str, where: str) -> Any:
    def change(content: Content) -> None:
        listed = content["plant"]["effects"]
        content["plant"]["effects"] = [entry for entry in listed if (entry["effect"], entry["where"]) != (name, where)]

    return change


def excursion() -> np.ndarray:
    """Commands (V) of a short move of both joints in both directions."""
    t = np.arange(900) * 1e-3
    return np.column_stack([1.0 * np.sin(2 * np.pi * 2.3 * t), 3.0 * np.sin(2 * np.pi * 1.7 * t)])


def moved(sim: SimulatedRig) -> dict[str, np.ndarray]:
    return sim.run(excursion(), 1e-3, sense=True)


def neutral_values(name: str, values: Mapping[str, Any]) -> Content:
    """The effect's, as a rig file has them: a sign is a whole number, a list is neutral in each of its entries."""
    neutral: Content = {}
    for key, value in EFFECTS[name].neutral.items():
        if key not in values:
            continue  # one of two ways to write it
        several = isinstance(values.get(key), list)
        neutral[key] = [value] * len(values[key]) if several else int(value) if name == "sensor_polarity" else value
    return neutral


@pytest.mark.parametrize(("name", "case"), CASES, ids=IDS)
def test_neutral_is_absent_and_the_rest_is_not(name: str, case: Case) -> None:
    """Neutral value = no entry, bit for bit in every signal and the whole state; the case's values = a visible difference."""
    where, values, signal = case.where, case.values, case.signal
    absent = SimulatedRig(ornl(warm, deleted(name, where)), seed=2)
    without_effect = moved(absent)
    entry = {"effect": name, "where": where, **values}
    neutral = SimulatedRig(ornl(warm, with_effects(entry | neutral_values(name, values))), seed=2)
    with_neutral = moved(neutral)
    for key, expected in without_effect.items():
        assert np.array_equal(with_neutral[key], expected, equal_nan=True), key
    assert np.array_equal(neutral.state, absent.state)
    present = moved(SimulatedRig(ornl(warm, with_effects(entry)), seed=2))
    change = np.nanmax(np.abs(present[signal] - without_effect[signal]))
    assert change > 1e-4 * np.nanmax(np.abs(without_effect[signal] - np.nanmean(without_effect[signal]))) + 1e-12


@pytest.mark.parametrize(("name", "case"), CASES, ids=IDS)
def test_what_many_periods_in_one_call_do_not_compute_again_changes_no_bit(name: str, case: Case) -> None:
    """The rates kept from the period before are those that a call of one period computes anew, whatever the effect does to them."""
    rig = ornl(warm, with_effects({"effect": name, "where": case.where, **case.values}))
    single = SimulatedRig(rig, seed=2)
    together, signals = SimulatedRig(rig, seed=2), single.signal_names()
    found = together.run(excursion(), 1e-3)
    for row, volts in enumerate(excursion().tolist()):
        assert [single.true_signal(signal) for signal in signals] == [found[signal][row] for signal in signals], row
        single.advance(volts, 1e-3)
    assert np.array_equal(together.state, single.state)


def test_every_effect_of_a_rig_file_is_there_and_has_a_case() -> None:
    """The names of the contract (a rig file may hold any of them); every one is tried on the testbed."""
    assert set(NAMES.split()) <= set(EFFECTS) == {name for name, _ in CASES}


@pytest.mark.parametrize("name", EFFECTS)
def test_effect_files_are_complete(name: str) -> None:
    """One file an effect: an equation in its docstring, look-alikes that exist, described keys."""
    effect = EFFECTS[name]
    assert inspect.getdoc(inspect.getmodule(effect.entry))
    assert set(effect.look_alikes) <= set(EFFECTS) - {name}
    assert effect.fingerprint.endswith(".")
    for key, field in effect.entry.model_fields.items():
        if key in ("effect", "where", "quantity_kind", "sign", "sensor_on"):
            continue
        assert field.description, key
        assert any(unit_at(field, kind) is not None for kind in ("rotary", "angle")), key


def test_effects_stand_in_the_order_of_their_places() -> None:
    """Rig files, the reference and the search list joint, valve, actuator, supply, link and sensor effects in this order."""
    assert [name for name in EFFECTS if name in NAMES.split()] == NAMES.split()


def test_deleting_every_effect_leaves_an_ideal_machine() -> None:
    """No friction, rigid link, constant supply: a released arm keeps turning, and the spool is where it is told."""

    def nothing(content: Content) -> None:
        content["plant"]["effects"] = []

    sim = SimulatedRig(ornl(nothing))
    result = sim.run(np.tile([0.908, 0.0], (200, 1)), 1e-3)
    assert result["rotary.spool"][20:] == pytest.approx(0.1, rel=1e-12)
    assert (result["tip.deflection"] == 0).all()
    assert (result["rotary.supply_pressure"] == sim.parameters.values[C.SUPPLY_PRESSURE]).all()


def test_spool_without_lag_still_has_a_slew_rate() -> None:
    sim = SimulatedRig(ornl(deleted("valve_lag", ROTARY), deleted("valve_hysteresis", ROTARY)))
    spool = sim.run(np.tile([9.08, 0.0], (15, 1)), 1e-3)["rotary.spool"]
    assert spool[:11] == pytest.approx(np.arange(11) * 0.1, abs=1e-9)
    assert spool[11:] == pytest.approx(1.0)


def test_transport_delay_moves_the_response_in_time() -> None:
    """Same response, later by exactly the delay (a multiple of the period)."""
    prompt = moved(SimulatedRig(ornl()))
    late = moved(SimulatedRig(ornl(with_effects({"effect": "transport_delay", "where": ROTARY, "delay": "20 ms"}))))
    assert late["rotary.spool"][20:] == pytest.approx(prompt["rotary.spool"][:-20], abs=1e-9)


def test_effects_on_a_force_axis() -> None:
    """The drive of a plain axis has the valve's command-side effects too."""
    entries = [
        {"effect": "transport_delay", "where": "axis", "delay": "5 ms"},
        {"effect": "valve_saturation", "where": "axis", "opening": 0.3},
        {"effect": "valve_lag", "where": "axis", "time_constant": "2 ms"},
        {"effect": "asymmetric_friction", "where": "axis", "coefficient_difference": -73.7},
    ]
    result = SimulatedRig(variant("force_axis", with_effects(*entries))).run(np.full((400, 1), 5.0), 1e-3)
    assert result["axis.spool"][4] == pytest.approx(result["axis.spool"][0])
    assert result["axis.spool"].max() == pytest.approx(0.3, rel=0.2)
