"""Read rig and maneuver files. All problems of a file are reported at once, each with file:line:column."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, cast

from config.errors import ConfigError
from config.loading.cross_checks import cross_check
from config.loading.cross_checks_devices import declared_devices
from config.loading.identified import with_identified
from config.loading.overrides import apply_overrides, as_it_was
from config.loading.shipped import find
from config.parsing.problems import Problem, config_error
from config.parsing.validation import validated
from config.parsing.yaml_tree import YamlTree, parse
from config.schema.maneuver import AnyManeuver, Maneuver
from config.schema.rig import Rig
from config.whole_file import system_advice

__all__ = [
    "LoadedManeuver", "LoadedRig", "apply_overrides", "changed_rig", "find", "load_maneuver", "load_rig", "maneuver_from_text",
    "rig_from_text",
]  # fmt: skip


_LOG = b"\x89MCAP"  # how a log begins


@dataclass(frozen=True, slots=True)
class LoadedRig:
    """A rig, the text it came from (it goes into every log; numbers of a calibration record are put in) and where that was."""

    rig: Rig
    text: str
    path: str


@dataclass(frozen=True, slots=True)
class LoadedManeuver:
    """A maneuver, the text it came from and where that was."""

    maneuver: Maneuver
    text: str
    path: str


def load_rig(path: str | Path) -> LoadedRig:
    """Load a rig file, given as a path or as the name of a shipped rig ("ornl_testbed").

    A file that can be read may still name devices that cannot work: `check` says so, and `refuse_unusable` keeps it from the daemon.
    """
    file = find("rigs", path)
    text = read_text(file)
    try:
        rig_from_text(text, str(file))
    except ConfigError as error:
        raise _with_devices(error, text, str(file)) from error
    text = with_identified(text, file)
    return LoadedRig(rig_from_text(text, str(file)), text, str(file))


def load_maneuver(path: str | Path) -> LoadedManeuver:
    """Load a maneuver file, given as a path or as the name of a shipped maneuver."""
    file = find("maneuvers", path)
    text = read_text(file)
    return LoadedManeuver(maneuver_from_text(text, str(file)), text, str(file))


@lru_cache(maxsize=64)
def rig_from_text(text: str, name: str = "rig.yaml") -> Rig:
    """The rig in `text`; `name` stands in the messages. The result is frozen and cached."""
    tree = parse(text, name)
    rig, problems = _rig(tree)
    _raise_if_any(tree, problems)
    return cast(Rig, rig)


def changed_rig(text: str, path: str, assignments: Sequence[str]) -> LoadedRig:
    """The rig in `text` with overrides put in. A ConfigError mends what they have changed to what was there."""
    changed = apply_overrides(text, assignments)
    try:
        return LoadedRig(rig_from_text(changed, path), changed, path)
    except ConfigError as error:
        mend = as_it_was(text, assignments, str(error)) if assignments else error.refusal.mend
        error.refusal = replace(error.refusal, mend=mend)
        raise


@lru_cache(maxsize=64)
def maneuver_from_text(text: str, name: str = "maneuver.yaml") -> Maneuver:
    """The maneuver in `text`; `name` stands in the messages. The result is frozen and cached."""
    tree = parse(text, name)
    _check_kind(tree, "maneuver/1")
    maneuver, problems = validated(AnyManeuver, tree)
    _raise_if_any(tree, problems)
    return cast(Maneuver, maneuver)


def read_text(path: Path) -> str:
    """The text of a configuration file; ConfigError when it cannot be read or is not UTF-8."""
    try:
        return path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        reason = error.strerror or str(error)
        raise ConfigError("the file cannot be read", value=reason, where=str(path), next_step=system_advice(error)) from error
    except UnicodeDecodeError as error:
        if error.object.startswith(_LOG):
            advice = f"`longreach log info {shlex.quote(str(path))}` shows what is in it."
            raise ConfigError("this is a log, not a file of text", where=str(path), next_step=advice) from error
        line = error.object.count(b"\n", 0, error.start) + 1
        column = error.start - error.object.rfind(b"\n", 0, error.start)
        byte = f"byte 0x{error.object[error.start]:02x}"
        raise ConfigError(
            "the file is not UTF-8 text", value=byte, where=f"{path}:{line}:{column}", next_step="Save it as UTF-8."
        ) from error


def _rig(tree: YamlTree) -> tuple[Any, list[Problem]]:
    _check_kind(tree, "rig/1")
    rig, problems = validated(Rig, tree)
    return rig, [*problems, *cross_check(tree)]


def _with_devices(error: ConfigError, text: str, name: str) -> ConfigError:
    """The same problems and those of the devices, so that all are told at once."""
    try:
        tree = parse(text, name)
        problems = [*tree.problems, *_rig(tree)[1], *declared_devices(tree).problems]
    except ConfigError:
        return error  # no rig file, or no YAML
    return config_error(name, problems)


def _check_kind(tree: YamlTree, wanted: str) -> None:
    """Refuse the wrong kind of file before hundreds of unknown keys are listed."""
    kind: Any = tree.plain.get("longreach")
    if kind == wanted:
        return
    what = f"this file is {kind!r}, not {wanted!r}" if kind else "the key 'longreach' is missing, which says what this file is"
    advice = f"A {wanted.split('/')[0]} file begins with longreach: {wanted}."
    if kind == "rig/1":
        advice += f" `longreach check {shlex.quote(tree.name)}` reads this one."
    raise config_error(tree.name, [tree.problem(("longreach",) if kind else (), what, next_step=advice)])


def _raise_if_any(tree: YamlTree, problems: list[Problem]) -> None:
    if problems or tree.problems:
        raise config_error(tree.name, [*tree.problems, *problems])
