"""A plug-in's own code, run where a rig file is read: whatever it raises is told as an error of the plug-in, with its place there."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pydantic

from config.errors import ConfigError, LongreachError
from config.options.device_options import DeviceOptions, RigNames

_PYDANTIC = Path(pydantic.__file__).parent


def loaded(point: EntryPoint, driver: str) -> Any:
    """What an entry point names: factory or options of this driver. ConfigError when it can't be imported."""
    try:
        return point.load()
    except Exception as error:  # whatever a foreign module raises on import
        what, advice = f"the driver {driver!r} cannot be loaded", f"Its entry point is {point.value!r}: what does not load there?"
        raise ConfigError(what, value=_said(error), next_step=advice) from error


@contextmanager
def working(driver: str, what: str) -> Iterator[None]:
    """ConfigError for whatever the code inside raises."""
    try:
        yield
    except LongreachError:
        raise
    except Exception as error:
        advice = f"Mend it at {_place(error)}, or tell its maker."
        raise ConfigError(f"{what} of the driver {driver!r} fails", value=_said(error), next_step=advice) from error


def try_declarations(driver: str, options: DeviceOptions, names: RigNames) -> None:
    """Everything that a class of options says is asked once. ConfigError where its code fails."""
    with working(driver, "input_channels()"):
        options.input_channels(names)
    with working(driver, "output_channels()"):
        options.output_channels(names)
    with working(driver, "address()"):
        options.address()
    with working(driver, "must_prove()"):
        options.must_prove()
    with working(driver, "warnings()"):
        list(options.warnings())


def _place(error: Exception) -> str:
    """The last line that is not pydantic's, in which a missing attribute ends."""
    at = [frame for frame in traceback.extract_tb(error.__traceback__) if _PYDANTIC not in Path(frame.filename).parents][-1]
    return f"{at.filename}:{at.lineno}"


def _said(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"
