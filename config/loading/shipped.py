"""The files that come with longreach: rigs, maneuvers and import maps, found by their bare name."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from config.errors import ConfigError
from config.parsing.nearest import nearest

_ROOM = Path(__file__).parents[1]
_ALIKE = 0.8  # of the letters, between a name and the shipped one that is proposed for it


def shipped(kind: str) -> dict[str, Path]:
    """Name → file of everything shipped of one kind: "rigs", "maneuvers" or "maps"."""
    return {path.stem: path for path in sorted((_ROOM / kind).glob("*.yaml"))}


def find(kind: str, name: str | Path) -> Path:
    """The file a user means: a path as it is, a bare name among the shipped files. ConfigError with what was meant instead."""
    path = Path(name)
    if path.suffix or len(path.parts) > 1 or path.is_file():
        return path
    known = shipped(kind)
    if str(name) not in known:
        raise _unknown(kind, str(name), known)
    return known[str(name)]


def _unknown(kind: str, name: str, known: Iterable[str]) -> ConfigError:
    """With the file of that name where there is one. Else a shipped name is proposed only for a slip of the keys or its beginning: another
    arm's rig, or a motion that was not meant, is worse than none."""
    what, own = f"{name!r} is not among the shipped {kind}", f"{name}.yaml"
    if Path(own).is_file():
        return ConfigError(what, next_step="A file of that name is here: give its ending too.", mend={name: own})
    near = nearest(name, known, _ALIKE) or next((each for each in known if name and each.startswith(name)), None)
    next_step = f"Give a path ending in .yaml, or one of: {', '.join(known)}."
    return ConfigError(f"{what}: nearest is {near!r}" if near else what, next_step=next_step)
