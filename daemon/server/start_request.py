"""From the parameters of a `start` request to a planned run: maneuver by name or text, parameters, shaper, repeats; what can be started."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import yaml

from config.errors import ConfigError, DaemonError, ManeuverError
from config.loading.load import find, load_maneuver, maneuver_from_text, read_text
from config.loading.shipped import shipped
from config.parsing.yaml_tree import parse
from config.schema.maneuver import maneuver_content
from config.schema.rig import Rig
from daemon.loop.command import StartRun
from daemon.server.protocol import LONGEST_COUNTDOWN_S
from servo_control.planning.mending import plan_or_mend
from servo_control.planning.run_request import BY_HAND, RunRequest
from servo_control.planning.runnable import why_not
from servo_control.shapers.shaper_choice import refuse_idle_options
from servo_control.streaming.stream_plan import default_filter, plan_stream

_KEYS = {"maneuver", "parameters", "shaper", "repeat", "approach", "countdown_s"}
_STREAM_KEYS = {"shaper", "countdown_s"}
_BY_HAND = {"name": "by hand", "kind": BY_HAND}


def start_run(rig: Rig, number: int, params: Mapping[str, Any], position: Sequence[float]) -> StartRun:
    """Plan the run that `params` ask for, from the joint positions `position` (rad or m, in the order of the rig).

    `maneuver`: {"name": shipped} or {"text": YAML, "name": for messages}; `parameters`: {"y0": "30 in"} or ["y0=30 in"];
    `shaper`: see servo_control.shapers.shaper_choice; `repeat`, `approach`, `countdown_s` (default: the rig's).
    Raises DaemonError for parameters that are no request, ConfigError and ManeuverError for what they request.
    """
    _refuse_unknown("start", params, _KEYS)
    content, text = requested_maneuver(params.get("maneuver"), params.get("parameters") or {})
    request = RunRequest(
        run=number,
        maneuver=content,
        shaper=_shaper(params, {"kind": "none"}),
        repeat=_typed(params, "repeat", int, 1),
        start_position=[float(value) for value in position],
        approach=_typed(params, "approach", bool, False),
    )
    return StartRun(plan_or_mend(rig, request), request.as_json(), text, _countdown_s(rig, params))


def start_stream(rig: Rig, number: int, params: Mapping[str, Any], position: Sequence[float]) -> StartRun:
    """Prepare a run that is driven by hand: see `start_run`. `shaper` defaults to one that follows the rig's link, on all joints."""
    _refuse_unknown("stream", params, _STREAM_KEYS)
    shaper = _shaper(params, default_filter(rig))
    request = RunRequest(number, dict(_BY_HAND), shaper, start_position=[float(value) for value in position])
    return StartRun(plan_stream(rig, request), request.as_json(), yaml.safe_dump(_BY_HAND), _countdown_s(rig, params))


def _shaper(params: Mapping[str, Any], default: dict[str, Any]) -> dict[str, Any]:
    shaper: dict[str, Any] = _typed(params, "shaper", dict, default)
    refuse_idle_options(shaper)
    return shaper


def _refuse_unknown(method: str, params: Mapping[str, Any], keys: set[str]) -> None:
    unknown = sorted(set(params) - keys)
    if unknown:
        raise DaemonError(f"unknown parameter of {method}", value=", ".join(unknown), limit=", ".join(sorted(keys)))


def _countdown_s(rig: Rig, params: Mapping[str, Any]) -> float:
    countdown_s = _typed(params, "countdown_s", (int, float), rig.loop.countdown_s)
    if not 0.0 <= countdown_s <= LONGEST_COUNTDOWN_S:
        raise DaemonError("countdown out of range", value=countdown_s, limit=f"0 to {LONGEST_COUNTDOWN_S:g}", unit="s")
    return float(countdown_s)


def requested_maneuver(maneuver: Any, parameters: Any) -> tuple[dict[str, Any], str]:
    """Content (as in a run's request) and text of the maneuver that `maneuver` and `parameters` of a start ask for."""
    original = _maneuver_text(maneuver)
    text, name = _with_parameters(*original, parameters)
    try:
        return maneuver_content(maneuver_from_text(text, name)), text
    except ConfigError as error:
        error.refusal = replace(error.refusal, mend=_as_it_was(*original, error.refusal.mend) or error.refusal.mend)
        raise


def _as_it_was(text: str, name: str, keys: Iterable[str]) -> dict[str, str]:
    """What the maneuver itself has there: it runs with that, which it need not with a value that is merely allowed."""
    content = parse(text, name).plain
    tops = {_top(key) for key in keys}
    return {top: _one_line(content[top]) for top in tops if top in content} if isinstance(content, dict) else {}


def _one_line(value: Any) -> str:
    return yaml.safe_dump(value, default_flow_style=True, width=10_000).removesuffix("\n...\n").strip()


def _maneuver_text(maneuver: Any) -> tuple[str, str]:
    """Text and name of the maneuver file."""
    if isinstance(maneuver, str):
        maneuver = {"name": maneuver}
    if not isinstance(maneuver, Mapping) or not isinstance(maneuver.get("name", ""), str):
        advice = 'Example: {"maneuver": {"name": "jog"}}.'
        raise DaemonError("start needs a maneuver, by name or as text", value=type(maneuver).__name__, next_step=advice)
    name = maneuver.get("name", "maneuver.yaml")
    if isinstance(maneuver.get("text"), str):
        return maneuver["text"], name
    path = find("maneuvers", name)
    return read_text(path), str(path)


def _with_parameters(text: str, name: str, parameters: Any) -> tuple[str, str]:
    """The maneuver's text with top-level keys replaced. It is written anew, so comments are lost when something changes."""
    content = parse(text, name).plain if parameters else None  # plain YAML 1.1 would read the key `on` as true
    if not isinstance(content, dict):
        return text, name
    changes = dict(_assignment(item, content) for item in parameters) if isinstance(parameters, list) else parameters
    if not isinstance(changes, Mapping):
        raise DaemonError("parameters must be an object or a list of KEY=VALUE", value=type(parameters).__name__)
    for key in changes:
        _refuse_inner(key, content, name)
    return yaml.safe_dump({**content, **changes}, sort_keys=False, allow_unicode=True), f"{name} with {', '.join(changes)} changed"


def _refuse_inner(key: str, content: Mapping[str, Any], name: str) -> None:
    if _top(key) != key:
        advice = f"Write it in the file, or set all of {_top(key)}."
        raise ManeuverError("a parameter is a whole key of the maneuver", value=key, limit=", ".join(content), where=name, next_step=advice)


def _top(key: str) -> str:
    return re.split(r"[.\[]", key)[0]


def _assignment(item: Any, content: Mapping[str, Any]) -> tuple[str, Any]:
    key, equals, value = item.partition("=") if isinstance(item, str) else ("", "", "")
    if not equals or not key.strip():
        mend = {key: f"{key}={_one_line(content[key])}"} if key in content else {}
        raise ManeuverError("a parameter is written KEY=VALUE", value=repr(item), next_step="Example: 'y0=30 in'.", mend=mend)
    try:
        return key.strip(), yaml.safe_load(value)
    except yaml.YAMLError as error:
        raise DaemonError("the value of a parameter cannot be read", value=repr(value), where=key.strip()) from error


def _typed(params: Mapping[str, Any], key: str, kind: Any, default: Any) -> Any:
    value = params.get(key, default)
    if value is None:
        return default
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise DaemonError("wrong kind of value in start", value=repr(value), where=key)
    return value


def judged_maneuvers(rig: Rig) -> list[dict[str, Any]]:
    """Name, kind and description of every shipped maneuver; `reason`: why this rig cannot run it, empty when it can."""
    maneuvers = [load_maneuver(path).maneuver for path in shipped("maneuvers").values()]
    rows = [(maneuver_content(maneuver), why_not(rig, maneuver)) for maneuver in maneuvers]
    return [{**{key: content[key] for key in ("name", "kind", "description")}, "reason": reason} for content, reason in rows]
