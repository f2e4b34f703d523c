"""The files that come with longreach: rigs, maneuvers and import maps, found by their bare name."""

from __future__ import annotations

from pathlib import Path

from config.errors import ConfigError
from config.parsing.nearest import nearest_text

_ROOM = Path(__file__).parents[1]


def shipped(kind: str) -> dict[str, Path]:
    """Name → file of everything shipped of one kind: "rigs", "maneuvers" or "maps"."""
    return {path.stem: path for path in sorted((_ROOM / kind).glob("*.yaml"))}


def find(kind: str, name: str | Path) -> Path:
    """The file a user means: a path as it is, a bare name among the shipped files. ConfigError with the nearest name."""
    path = Path(name)
    if path.suffix or len(path.parts) > 1 or path.is_file():
        return path
    known = shipped(kind)
    if str(name) not in known:
        next_step = f"Give a path ending in .yaml, or one of: {', '.join(known)}."
        raise ConfigError(f"{str(name)!r} is not among the shipped {kind}{nearest_text(str(name), known)}", next_step=next_step)
    return known[str(name)]
