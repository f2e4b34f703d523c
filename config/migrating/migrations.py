"""What has changed in rig files since they were first written: the table of migrations, oldest first.

A key that was renamed, moved or given another meaning gets an entry here in the same change; `tests/config/migrating` holds that every rig
file the repository ever shipped loads after its migrations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from config.errors import UnitError
from config.migrating.line_edits import Path, moved_up, new_value, without
from config.parsing.yaml_tree import YamlTree, dotted, parse
from config.units import to_si


@dataclass(frozen=True, slots=True)
class Migration:
    """`find`: the places of a tree that are still written the old way; `rewrite`: the text with one of them rewritten. `told`: what it does
    and why, for people."""

    key: str
    told: str
    find: Callable[[YamlTree], Iterator[Path]]
    rewrite: Callable[[YamlTree, Path], str]


@dataclass(frozen=True, slots=True)
class Migrated:
    """One place that was rewritten: line in the old text, its path, and what was done."""

    line: int
    path: str
    told: str

    def text(self) -> str:
        return f"line {self.line}, {self.path}: {self.told}"


def migrated(text: str, name: str = "rig.yaml") -> tuple[str, list[Migrated]]:
    """The text in today's words and what was rewritten, nothing for a file of today. ConfigError where it is no YAML."""
    done: list[Migrated] = []
    for migration in MIGRATIONS:
        while (path := next(migration.find(parse(text, name)), None)) is not None:
            tree = parse(text, name)
            done.append(Migrated(tree.mark(path, of_key=True)[0], dotted(path), migration.told))
            text = migration.rewrite(tree, path)
    return text, done


def _places(tree: YamlTree, *path: str) -> Iterator[Path]:
    """Of one fixed key."""
    parent = tree.value(path[:-1])
    if isinstance(parent, dict) and path[-1] in parent:
        yield path


def _proof_options(tree: YamlTree) -> Iterator[Path]:
    devices = tree.value(("devices",))
    for name, device in devices.items() if isinstance(devices, dict) else ():
        options = device.get("options") if isinstance(device, dict) else None
        if isinstance(options, dict) and "demand_proof" in options and "demand_proof" not in device:
            yield ("devices", name, "options", "demand_proof")


_FRICTION_GAIN = ("end_point", "friction_gain")
_POINTS = ("servo", "rotary", "oil_compensation", "points")


def _friction_gain_in_volts(tree: YamlTree) -> Iterator[Path]:
    """One that is stated in volts per rate, as before; a bare number cannot be told from today's."""
    for path in _places(tree, *_FRICTION_GAIN):
        if _is(tree.value(path), "V*s/rad"):
            yield path


def _as_share(tree: YamlTree, path: Path) -> str:
    """volts = friction(T) × share, so the share of the largest friction never gives more volts than the old gain did."""
    points = tree.value(_POINTS)
    frictions = [to_si(point["friction"], "V") for point in points or () if isinstance(point, dict) and _is(point.get("friction"), "V")]
    largest_V = max(frictions, default=0.0)
    if largest_V <= 0.0:
        return without(tree, path, "it overcomes a share of servo.rotary.oil_compensation's friction now, of which there is none")
    share = to_si(tree.value(path), "V*s/rad") / largest_V
    return new_value(tree, path, f"{share:.4g} s/rad", f"over the largest friction of the oil table, {1e3 * largest_V:.4g} mV")


def _is(value: Any, unit: str) -> bool:
    if not isinstance(value, str):
        return False
    try:
        to_si(value, unit)
    except UnitError:
        return False
    return True


MIGRATIONS = (
    Migration(
        "devices.NAME.options.demand_proof",
        "stands at the device now, not in its options, so that plug-ins can be demanded too",
        _proof_options,
        lambda tree, path: moved_up(tree, path, "moved to the device"),
    ),
    Migration(
        "end_point.frequency_ratio",
        "is gone: filters are made for the clamped link (docs/decisions/motion/0008-feedback-beyond-the-planned-deflection.md)",
        lambda tree: _places(tree, "end_point", "frequency_ratio"),
        lambda tree, path: without(tree, path, "gone, see decision 8"),
    ),
    Migration(
        "end_point.friction_gain in V*s/rad",
        "is a share of the friction per rate now, in s/rad (docs/decisions/motion/0009-friction-of-a-resting-joint.md)",
        _friction_gain_in_volts,
        _as_share,
    ),
)
