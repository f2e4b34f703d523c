"""Every effect: in the registry, without influence when absent or neutral, of influence when not, and told apart from others."""

from __future__ import annotations

import ast
import inspect
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plants import Content, SimulatedRig, ornl, variant, with_effects

import sim_backend.effects as effects_package
from config.effect_entry import unit_at
from config.plant import EFFECT_SECTIONS, effect_name
from sim_backend.effects.registry import REGISTRY
from sim_backend.layout import C

ROTARY, PRISMATIC, SUPPLY, LINK, SENSOR = "rotary", "prismatic", "supply", "link", "sensor:rotary.position"

# Every effect with values at which it must be seen, and where to look; the neutral values come from the registry.
CASES: list[tuple[str, str, Content, str]] = [
    ("coulomb_friction", ROTARY, {"friction": 105, "temperature_slope": -0.004}, "rotary.position"),
    ("coulomb_friction", PRISMATIC, {"friction": 1500}, "prismatic.position"),
    ("stiction", ROTARY, {"excess": 60, "velocity": 0.03}, "rotary.position"),
    ("viscous_friction", PRISMATIC, {"coefficient": 4000, "oil_share": 0.5}, "prismatic.position"),
    ("asymmetric_friction", ROTARY, {"friction_difference": 40, "coefficient_difference": 300}, "rotary.position"),
    ("pressure_friction", PRISMATIC, {"coefficient": 1e-4}, "prismatic.position"),
    ("backlash", ROTARY, {"gap": 0.004, "stiffness": 1.5e5, "damping": 100, "actuator_mass": 2}, "rotary.position"),
    ("backlash", PRISMATIC, {"gap": 0.0005, "stiffness": 1e7, "actuator_mass": 5}, "prismatic.position"),
    ("inertia_error", ROTARY, {"extra": 3}, "rotary.position"),
    ("gravity", ROTARY, {"tilt": 0.02}, "prismatic.pressure_a"),
    ("valve_deadband", ROTARY, {"overlap": 0.01}, "rotary.position"),
    ("valve_hysteresis", PRISMATIC, {"half_width": 0.01}, "prismatic.position"),
    ("valve_null_bias", ROTARY, {"bias": 0.01, "temperature_slope": 5e-4}, "rotary.position"),
    ("valve_saturation", ROTARY, {"opening": 0.05}, "rotary.position"),
    ("valve_lag", PRISMATIC, {"time_constant": 0.004, "damping_ratio": 0.7}, "prismatic.position"),
    ("valve_flow_asymmetry", ROTARY, {"difference": 0.1}, "rotary.position"),
    ("transport_delay", ROTARY, {"delay": 0.0042}, "rotary.position"),
    ("cross_leakage", ROTARY, {"conductance": 1e-11}, "rotary.position"),
    ("external_leakage", PRISMATIC, {"conductance": 1e-12}, "prismatic.pressure_a"),
    ("bulk_modulus_temperature", ROTARY, {"temperature_slope": -0.01, "hose_temperature_slope": -0.01}, "rotary.position"),
    ("entrained_air", PRISMATIC, {"fraction": 0.02}, "prismatic.position"),
    ("hose_compliance", ROTARY, {"compliance": 2e-9}, "rotary.position"),
    ("supply_droop", SUPPLY, {"inverse_gas_volume": 433, "pump_flow": 6e-4}, "rotary.supply_pressure"),
    ("return_back_pressure", SUPPLY, {"pressure": 2e5, "resistance": 1e11}, "rotary.return_pressure"),
    ("line_loss", SUPPLY, {"resistance": 2.5e11}, "prismatic.supply_pressure"),
    ("link_flexibility", LINK, {"bending_stiffness": 3000, "damping_ratio": 0.01}, "tip.deflection"),
    ("payload_error", LINK, {"extra": 4}, "tip.deflection"),
    ("link_damping_error", LINK, {"extra": 0.01}, "tip.deflection"),
    ("sensor_delay", SENSOR, {"delay": 0.01}, "raw"),
    ("sensor_scale", SENSOR, {"factor": 1.05}, "raw"),
    ("sensor_offset", SENSOR, {"offset": 0.01}, "raw"),
    ("sensor_polarity", SENSOR, {"sign": -1}, "raw"),
    ("sensor_quantization", SENSOR, {"step": 0.01}, "raw"),
    ("unnamed_remainder", ROTARY, {"velocity": [-0.2, 0.0, 0.2], "force": [40, 0, -40]}, "rotary.position"),
    ("unnamed_remainder", ROTARY, {"position": [-0.1, 0.1], "force": [30, -30]}, "rotary.position"),
    ("unnamed_remainder", PRISMATIC, {"position": [0.9, 1.1], "friction": [0, 900]}, "prismatic.pressure_a"),
    ("unnamed_remainder", PRISMATIC, {"command": ["-3 V", "3 V"], "force": [200, -200]}, "prismatic.pressure_a"),
    ("unnamed_remainder", PRISMATIC, {"pressure_difference": ["-10 bar", "10 bar"], "force": [200, -200]}, "prismatic.pressure_a"),
]
IDS = [f"{name} at {where}" for name, where, _, _ in CASES]


def warm(content: Content) -> None:
    content["plant"]["oil"]["initial_temperature"] = "45 degC"


def deleted(name: str, where: str) -> Any:
    def change(content: Content) -> None:
        listed = content["plant"]["effects"]
        content["plant"]["effects"] = [entry for entry in listed if (entry["effect"], entry["where"]) != (name, where)]

    return change


def moved(sim: SimulatedRig) -> dict[str, np.ndarray]:
    """A short excursion of both joints in both directions."""
    t = np.arange(900) * 1e-3
    return sim.run(np.column_stack([1.0 * np.sin(2 * np.pi * 2.3 * t), 3.0 * np.sin(2 * np.pi * 1.7 * t)]), 1e-3, sense=True)


def neutral_values(name: str, values: Content) -> Content:
    """The registry's, as a rig file has them: a sign is a whole number, a list is neutral in each of its entries."""
    neutral: Content = {}
    for key, value in REGISTRY[name].neutral.items():
        if key not in values:
            continue  # one of two ways to write it
        several = isinstance(values.get(key), list)
        neutral[key] = [value] * len(values[key]) if several else int(value) if name == "sensor_polarity" else value
    return neutral


@pytest.mark.parametrize(("name", "where", "values", "signal"), CASES, ids=IDS)
def test_neutral_is_absent_and_the_rest_is_not(name: str, where: str, values: Content, signal: str) -> None:
    """Neutral value = no entry, bit for bit in every signal and the whole state; the case's values = a visible difference."""
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


def test_every_effect_of_the_design_has_a_case_and_a_registry_entry() -> None:
    names = {effect_name(section) for section in EFFECT_SECTIONS}
    assert set(REGISTRY) == names == {case[0] for case in CASES}
    assert len(names) == 32


@pytest.mark.parametrize("name", sorted(REGISTRY))
def test_effect_files_are_complete(name: str) -> None:
    """One file an effect: an equation in its docstring, writes that name real parameters, look-alikes that exist."""
    effect = REGISTRY[name]
    source = Path(inspect.getfile(effects_package)).parent / f"{name}.py"
    doc = ast.get_docstring(ast.parse(source.read_text(encoding="utf-8")))
    assert doc
    parameters = {field.alias or key for key, field in effect.entry.model_fields.items()} - {"effect", "where", "quantity_kind"}
    assert {write.parameter for write in effect.writes} == parameters
    assert set(effect.neutral) <= parameters
    assert set(effect.look_alikes) <= set(REGISTRY) - {name}
    assert effect.fingerprint.endswith(".")


@pytest.mark.parametrize("section", EFFECT_SECTIONS, ids=effect_name)
def test_parameters_have_units_and_descriptions(section: type) -> None:
    for key, field in section.model_fields.items():  # type: ignore[attr-defined]
        if key in ("effect", "where", "quantity_kind", "sign", "sensor_on"):
            continue
        assert field.description, key
        assert any(unit_at(field, kind) is not None for kind in ("rotary", "angle")), key


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
