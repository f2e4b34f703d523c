"""Finds the physical effects: every file of every library in the entry-point group `longreach.effects`, ours and those of others.

A library is a package. Each of its modules declares one effect as `EFFECT`; a name that begins with `_` is passed over. The group is
how this lowest room learns of what stands above it without importing it, as drivers are found.
"""

from __future__ import annotations

import importlib.util
import pkgutil
from collections.abc import Iterator, Mapping
from importlib.metadata import entry_points
from pathlib import Path

from config.errors import ConfigError, LongreachError
from config.schema.effect import Effect

GROUP = "longreach.effects"
_OURS = "longreach"
_AGAIN = "in its folder, run `python -m pip install --no-deps --no-build-isolation --editable .` again"


def library_folders() -> list[Path]:
    """Where the files of all libraries stand."""
    specs = (importlib.util.find_spec(point.value) for point in sorted(entry_points(group=GROUP)))
    return [Path(folder) for spec in specs if spec is not None for folder in spec.submodule_search_locations or ()]


def _declared(package: str) -> Iterator[Effect]:
    """The effect of every module of a library."""
    library = importlib.import_module(package)
    for module in sorted(found.name for found in pkgutil.iter_modules(library.__path__)):
        if module.startswith("_"):
            continue
        effect = getattr(importlib.import_module(f"{package}.{module}"), "EFFECT", None)
        if not isinstance(effect, Effect):
            raise ConfigError("the file of an effect declares EFFECT = Effect(...)", value=effect, where=f"{package}.{module}")
        if effect.name != module:
            raise ConfigError("the file of an effect has its name", value=effect.name, limit=module, where=f"{package}.{module}")
        yield effect


def _found() -> tuple[dict[str, Effect], list[str]]:
    """Effects by name in their order, and what is wrong with libraries: one that cannot be loaded is left out as a whole."""
    libraries = {point.name: point.value for point in entry_points(group=GROUP)}
    effects: dict[str, Effect] = {}
    problems: list[str] = []
    if _OURS not in libraries:
        problems.append(f"longreach was installed before it had a library of effects; {_AGAIN}")
    for name in sorted(libraries, key=lambda name: (name != _OURS, name)):
        try:
            new = {effect.name: effect for effect in _declared(libraries[name])}
        except LongreachError as error:
            problems.append(f"the library of effects {name!r} is left out: {error}")
            continue
        except Exception as error:  # whatever a foreign module raises on import
            problems.append(f"the library of effects {name!r} cannot be loaded: {type(error).__name__}: {error}")
            continue
        if twice := sorted(new.keys() & effects.keys()):
            problems.append(f"the library of effects {name!r} is left out: there is a {', '.join(twice)} already")
            continue
        effects |= new
    return dict(sorted(effects.items(), key=lambda item: (item[1].order, item[0]))), problems


_effects, _problems = _found()
EFFECTS: Mapping[str, Effect] = _effects  # by the word after `effect:` in a rig file
PROBLEMS: tuple[str, ...] = tuple(_problems)  # one sentence each
