"""The `options:` of a device, read with a schema of its driver's own: the same units, ranges and messages as the rest of the rig file."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

from config.errors import ConfigError, Refusal
from config.rig import Device
from config.validation import validated
from config.yaml_tree import parse


def options_as(schema: Any, name: str, device: Device) -> Any:
    """The options of the rig's device `name` as `schema` (a Section or a union of Sections).

    Raises ConfigError that lists every problem as devices.NAME.options: KEY ..., without line numbers: the options are plain data here.
    """
    where = f"devices.{name}.options"
    tree = parse(json.dumps(device.options, default=str), where)
    options, problems = validated(schema, tree)
    if not problems:
        return options
    refusals = tuple(replace(problem.refusal, where=where) for problem in problems)
    raise _config_error(refusals, where)


def _config_error(refusals: tuple[Refusal, ...], where: str) -> ConfigError:
    if len(refusals) == 1:
        only = refusals[0]
        return ConfigError(only.what, value=only.value, limit=only.limit, where=where, next_step=only.next_step)
    lines = "".join(f"\n  {refusal.text()}" for refusal in refusals)
    return ConfigError(f"{len(refusals)} problems in {where}:{lines}", problems=refusals)
