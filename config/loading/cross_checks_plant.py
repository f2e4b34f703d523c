"""Names in the plant section of a rig file that must be names of joints, signals or parts. On the plain content, as cross_checks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from config.parsing.nearest import nearest_text
from config.parsing.problems import Problem
from config.parsing.yaml_tree import YamlTree
from config.schema.effect_entry import LINEAR, ROTARY
from config.schema.plant_joint import motion_of
from config.signal_names import signal_measures


def cross_check_plant(tree: YamlTree) -> Iterator[Problem]:
    """Every name in the plant section that means nothing."""
    yield from _joints(tree)
    yield from _sensors(tree)
    yield from _places(tree)


def _joints(tree: YamlTree) -> Iterator[Problem]:
    joints, simulated = _mapping(tree, "joints"), _mapping(tree, "plant", "joints")
    for name in joints if simulated else ():
        if name not in simulated:
            yield tree.problem(("plant", "joints"), f"plant.joints has no entry for the joint {name!r}", of_key=True, next_step="Add it.")
    for name, joint in simulated.items() if joints else ():
        path = ("plant", "joints", name)
        if name not in joints:
            what = f"plant.joints.{name} is no joint of this rig{nearest_text(name, joints)}"
            yield tree.problem(path, what, of_key=True, next_step=f"Joints: {', '.join(joints)}.")
        elif isinstance(joint, dict) and _moves_otherwise(joint, motion := tree.value(("joints", name, "motion"))):
            what = f"plant.joints.{name}.actuator {joint['actuator']!r} does not move a {motion} joint"
            yield tree.problem((*path, "actuator"), what, next_step=f"It must fit joints.{name}.motion.")


def _moves_otherwise(joint: dict[str, Any], motion: Any) -> bool:
    """A motion that is missing or misspelt is told by itself."""
    return motion in (ROTARY, LINEAR) and motion_of(joint) not in (motion, "")


def _sensors(tree: YamlTree) -> Iterator[Problem]:
    known = _signals(tree)
    for name in _mapping(tree, "plant", "sensors") if _motions(tree) else ():
        if name not in known:
            what = f"{name!r} is not a signal of this plant{nearest_text(name, known)}"
            yield tree.problem(("plant", "sensors", name), what, of_key=True)


def _places(tree: YamlTree) -> Iterator[Problem]:
    """`where` of every effect; whether that effect can be at that place is a question for the plant section itself."""
    places = [*_motions(tree), "supply", "link", *(f"sensor:{name}" for name in _mapping(tree, "plant", "sensors"))]
    effects = tree.value(("plant", "effects"))
    for index, entry in enumerate(effects if isinstance(effects, list) else ()):
        where = entry.get("where") if isinstance(entry, dict) else None
        if isinstance(where, str) and where not in places:
            what = f"plant.effects[{index}].where: there is no {where!r} in this plant{nearest_text(where, places)}"
            yield tree.problem(("plant", "effects", index, "where"), what, next_step=f"Places: {', '.join(places)}.")


def _motions(tree: YamlTree) -> dict[str, str]:
    return {name: motion_of(joint) for name, joint in _mapping(tree, "plant", "joints").items() if isinstance(joint, dict)}


def _signals(tree: YamlTree) -> dict[str, str]:
    return signal_measures(_motions(tree))


def _mapping(tree: YamlTree, *path: str) -> dict[str, Any]:
    value = tree.value(path)
    return value if isinstance(value, dict) else {}
