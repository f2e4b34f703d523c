"""A plug-in's own code, run where a rig file is read: whatever it raises is told as an error of the plug-in, with its place there."""

from __future__ import annotations

import importlib
import inspect
import re
import reprlib
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pydantic

from config.errors import ConfigError, LongreachError
from config.options.device_options import Address, Channel, DeviceOptions, RigNames

_NOT_ITS_OWN = (*(Path(str(module.__file__)).parent for module in (pydantic, importlib)), Path(__file__).parents[1])


def loaded(point: EntryPoint, driver: str) -> Any:
    """What an entry point names: factory or options of this driver. ConfigError when it can't be imported."""
    try:
        return point.load()
    except (Exception, SystemExit) as error:  # whatever a foreign module raises on import, or where it would end the command
        what, place = f"the driver {driver!r} cannot be loaded", _place(error)
        advice = f"Its entry point is {point.value!r}: " + (f"mend it at {place}." if place else "what does not load there?")
        raise ConfigError(what, value=_said(error), next_step=advice) from error


@contextmanager
def working(driver: str, what: str) -> Iterator[None]:
    """ConfigError for whatever the code inside raises."""
    try:
        yield
    except LongreachError:
        raise
    except (Exception, SystemExit) as error:
        raise ConfigError(f"{what} of the driver {driver!r} fails", value=_said(error), next_step=_advice(_place(error))) from error


def try_declarations(driver: str, options: DeviceOptions, names: RigNames) -> None:
    """Everything that a class of options says is asked once. ConfigError where its code fails, or says what nobody can use."""
    channels = "a mapping of names to Channel"
    _try(driver, options.input_channels, _are_channels, channels, names)
    _try(driver, options.output_channels, _are_channels, channels, names)
    _try(driver, options.address, lambda said: said is None or isinstance(said, Address), "an Address or None")
    _try(driver, options.must_prove, lambda said: isinstance(said, bool), "True or False")
    _try(driver, options.warnings, _are_warnings, "pairs of an option and what is odd about it")


def _try(driver: str, asked: Any, is_usable: Callable[[Any], bool], wanted: str, *names: RigNames) -> None:
    what = f"{asked.__name__}()"
    with working(driver, what):
        said = asked(*names)
        if is_usable(said):
            return
    advice = _advice(declared_at(type(asked.__self__), asked.__name__))
    raise ConfigError(f"{what} of the driver {driver!r} must return {wanted}", value=f"got {reprlib.repr(said)}", next_step=advice)


def _are_channels(said: Any) -> bool:
    return isinstance(said, Mapping) and all(isinstance(name, str) and isinstance(channel, Channel) for name, channel in said.items())


def _are_warnings(said: Any) -> bool:
    return isinstance(said, Iterable) and all(isinstance(pair, tuple) and len(pair) == 2 for pair in said)


def declared_at(options: type, name: str) -> str:
    """FILE:LINE where a class of options, or the one it is derived from, declares a method or a field."""
    owner = next(kind for kind in options.__mro__ if name in {*vars(kind), *vars(kind).get("__annotations__", ())})
    try:
        lines, first = inspect.getsourcelines(owner)
    except OSError:  # it came without its source
        return owner.__module__
    declares = re.compile(rf" +(def {name}\b|{name} *:)")
    return f"{inspect.getsourcefile(owner)}:{first + max((k for k, line in enumerate(lines) if declares.match(line)), default=0)}"


def _place(error: BaseException) -> str:
    """The last line that is the plug-in's own, not of what loads or asks it; empty where none is."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith("<")]
    own = [frame for frame in frames if not any(folder in Path(frame.filename).parents for folder in _NOT_ITS_OWN)]
    return f"{own[-1].filename}:{own[-1].lineno}" if own else ""


def _advice(place: str) -> str:
    return f"Mend it at {place}, or tell its maker." if place else "Tell its maker."


def _said(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"
