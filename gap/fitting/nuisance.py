"""Every uncertain constant of the plant, with a prior from the provenance tag in the rig file's comment.

A name is only worth something when no constant within its own uncertainty explains the same gap; so all of them take part in every fit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from config.loading.load import LoadedRig
from config.parsing.provenance import FIXED, tag_of
from config.parsing.yaml_tree import YamlTree, parse
from config.schema.effect_entry import unit_at
from config.schema.model_fields import place_of_path
from config.schema.plant import Plant
from config.schema.plant_sensor import Sensor
from config.schema.rig import Rig
from config.schema.section import Section, yaml_key
from gap.fitting.model import Free, Path

# Relative standard deviation of a constant by where its number comes from; docs/guide/rig/rig-file.md has the table.
PRIOR_SD = {
    "P": 0.02,  # stated in the paper
    "DS": 0.03,  # read in a manufacturer's catalogue
    "M": 0.03,  # measured on this rig
    "B": 0.02,  # stated by a benchmark's authors
    "D": 0.10,  # derived from other numbers
    "C": 0.20,  # typical of the component family
    "A": 0.25,  # assumed
    "gap": 0.10,  # found by an earlier search
}
UNTAGGED_SD = 0.05
# Stiffness, damping and fading of the friction's bristles stand for how a contact yields before it slides. No real contact does it in
# just that form: one that yields in many small places is softer, one that hardly yields much stiffer.
FORM_OF_FRICTION = {"bristle_stiffness": 10.0, "bristle_damping": 3.0, "bristle_fade": 3.0}
OIL_SD_K = 2.0  # oil at the valves against the reservoir's thermometer, from which a log's temperature starts; per cent of °C mean nothing
LEAST_SD_OF_EFFECT = 0.10  # friction, leakage and air change with oil, wear and temperature, however well they were once known
HONEST = 2.0  # prior standard deviations within which 95 % of honest priors hold the true value
ALARM = 3.0  # prior standard deviations: the constant, its prior or the structure is wrong
LARGEST_PULL = 4.0  # prior standard deviations a fit may move a constant
_GEOMETRY = ("travel", "initial", "stop_stiffness", "stop_restitution_loss", "quantity_kind")
_SKIPPED = (
    "step_s",
    "thermal",
    "rated_pressure_drop_Pa",
    "density_kg_per_m3",
    "specific_heat_J_per_kg_K",
    "vapour_pressure_Pa",
    "walther_a",
    "walther_b",
)
# Gain, mass and friction of a plain servo axis scale together: no position log shows their common factor, so the drive's gain is held.
_SCALE_OF_FORCE = ("gain_N_per_V", "gain_N_m_per_V")
_ZERO_IS_NONE = ("bandwidth_Hz", "temperature_slope_per_K", "temperature_slope", "oil_share")  # no limit; the same at every temperature
_OF_A_SENSOR = ("bias", "bandwidth_Hz")  # resolution, noise and range are what the floor is made of


def nuisances(loaded: LoadedRig, channels: frozenset[str]) -> tuple[Free, ...]:
    """The free constants of a rig: everything numeric in `plant` but geometry of the stops, thermal constants and sensor noise.

    Sensor biases only for the channels compared. A constant of 0 stays 0: whatever is missing there is an effect. One with the tag
    [fixed] stays as it is.
    """
    return tuple(free for free, value in _all(loaded, channels) if value != 0.0 and free.tag != FIXED)


def held(loaded: LoadedRig, channels: frozenset[str]) -> tuple[Free, ...]:
    """The constants that a fit does not move, each with the range of its key: those tagged [fixed] (`scale`: 5 % of the value), and those
    of 0 (`scale`: 0) where 0 does not stand for "none"."""
    found = [(free, value) for free, value in _all(loaded, channels) if value == 0.0 or free.tag == FIXED]
    tree = parse(loaded.text, loaded.path)
    return tuple(_in_range(free, tree) for free, value in found if not (value == 0.0 and free.path[-1] in _ZERO_IS_NONE))


def _in_range(free: Free, tree: YamlTree) -> Free:
    at = ("plant", *(yaml_key(part) if isinstance(part, str) else part for part in free.path))
    field = place_of_path(Rig, at, tree.plain).field
    limits = field.metadata if field else ()
    low = next((float(limit.ge) for limit in limits if getattr(limit, "ge", None) is not None), -math.inf)
    high = next((float(limit.le) for limit in limits if getattr(limit, "le", None) is not None), math.inf)
    return replace(free, low=low, high=high, prior=False)


def _all(loaded: LoadedRig, channels: frozenset[str]) -> Iterator[tuple[Free, float]]:
    assert loaded.rig.plant is not None
    tree = parse(loaded.text, loaded.path)
    for path, key, unit, value in _constants(loaded.rig.plant, channels):
        yield _free(tree, path, key, unit, value), value


def _free(tree: YamlTree, path: Path, key: Path, unit: str, value: float) -> Free:
    tag = tag_of(tree, ("plant", *key))
    relative = FORM_OF_FRICTION.get(str(path[-1]), PRIOR_SD.get(tag, UNTAGGED_SD))
    sd = abs(value) * (max(relative, LEAST_SD_OF_EFFECT) if path[0] == "effects" else relative)
    sd = OIL_SD_K if path == ("oil", "initial_temperature_C") else sd
    low, high = value - LARGEST_PULL * sd, value + LARGEST_PULL * sd
    floor = 0.1 * value
    return Free(path, ".".join(map(str, ("plant", *key))), unit, value, sd, max(low, floor) if value > 0 else low,
                high if value > 0 else min(high, floor), True, tag)  # fmt: skip


def _constants(plant: Plant, channels: frozenset[str]) -> Iterator[tuple[Path, Path, str, float]]:
    """Path in the model, path in the file, unit and value of every candidate constant."""
    for name in ("joints", "oil", "supply", "link", "effects"):
        yield from _walk(getattr(plant, name), (name,), (name,))
    for name, sensor in plant.sensors.items():
        if name in channels:
            yield from _walk(sensor, ("sensors", name), ("sensors", name))


def _walk(node: Any, path: Path, key: Path) -> Iterator[tuple[Path, Path, str, float]]:
    if isinstance(node, dict):
        for name, item in node.items():
            yield from _walk(item, (*path, name), (*key, name))
    elif isinstance(node, tuple):
        for number, item in enumerate(node):
            yield from _walk(item, (*path, number), (*key, number))
    elif isinstance(node, Section):
        for name, field in type(node).model_fields.items():
            value = getattr(node, name)
            if name in (*_GEOMETRY, *_SKIPPED, *_SCALE_OF_FORCE) or (isinstance(node, Sensor) and name not in _OF_A_SENSOR):
                continue
            if isinstance(value, Section):
                yield from _walk(value, (*path, name), (*key, yaml_key(name)))
            elif isinstance(value, float):
                unit = unit_at(field, str(getattr(node, "quantity_kind", ""))) or ""
                yield (*path, name), (*key, yaml_key(name)), unit, value
