"""Interlocks against the supply and the oil they watch: a limit that can't hold keeps the arm from ever being armed."""

from __future__ import annotations

from collections.abc import Iterator

from config.checking.finding import Finding, warning_at
from config.parsing.yaml_tree import YamlTree
from config.schema.plant import Supply
from config.schema.rig import Rig


def check_limits(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    """Findings about `interlocks` against `plant` and `signals`."""
    yield from _against_plant(rig, tree)
    yield from _against_ranges(rig, tree)


def _against_plant(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    plant, limits = rig.plant, rig.interlocks
    if plant is None:
        return
    if plant.supply:
        yield from _supply(plant.supply, tree)
        supply_Pa, return_Pa = plant.supply.pressure_Pa, plant.supply.return_pressure_Pa
        yield from _compared(tree, "supply_pressure_min", limits.supply_pressure_min_Pa, supply_Pa, "plant.supply.pressure")
        yield from _compared(tree, "supply_pressure_max", limits.supply_pressure_max_Pa, supply_Pa, "plant.supply.pressure")
        yield from _compared(tree, "return_pressure_max", limits.return_pressure_max_Pa, return_Pa, "plant.supply.return_pressure")
    if plant.oil:
        start_C, where = plant.oil.initial_temperature_C, "plant.oil.initial_temperature"
        yield from _compared(tree, "oil_temperature_min", limits.oil_temperature_min_C, start_C, where)
        yield from _compared(tree, "oil_temperature_max", limits.oil_temperature_max_C, start_C, where)


def _supply(supply: Supply, tree: YamlTree) -> Iterator[Finding]:
    if supply.return_pressure_Pa >= supply.pressure_Pa:
        text = f"plant.supply.return_pressure is {_shown('Pa', supply.return_pressure_Pa)}, the supply {_shown('Pa', supply.pressure_Pa)}"
        yield warning_at(tree, ("plant", "supply", "return_pressure"), f"{text}: nothing drives the oil")


def _compared(tree: YamlTree, key: str, limit: float | None, value: float, where: str) -> Iterator[Finding]:
    if limit is None or not (value < limit if key.endswith("_min") else value > limit):
        return
    unit = "degC" if "temperature" in key else "Pa"
    text = f"interlocks.{key} is {_shown(unit, limit)}, but {where} is {_shown(unit, value)}"
    yield warning_at(tree, ("interlocks", key), f"{text}: the simulated rig can't be armed")


def _shown(unit: str, value: float) -> str:
    return f"{1e-6 * value:.4g} MPa" if unit == "Pa" else f"{value:.4g} {unit}"


def _against_ranges(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    """A reading that would satisfy the limit is refused as implausible before."""
    limits = rig.interlocks
    compared = (
        ("supply_pressure_min", limits.supply_pressure_min_Pa, "supply_pressure"),
        ("oil_temperature_min", limits.oil_temperature_min_C, "reservoir_temperature"),
    )
    for key, limit, measured in compared:
        for name, signal in rig.signals.items():
            if limit is not None and name.rpartition(".")[2] == measured and signal.high is not None and signal.high <= limit:
                unit = "degC" if "temperature" in key else "Pa"
                text = f"interlocks.{key} asks for {_shown(unit, limit)} at least, but signals.{name}.high is {_shown(unit, signal.high)}"
                yield warning_at(tree, ("interlocks", key), f"{text}: no believable reading can satisfy it")
