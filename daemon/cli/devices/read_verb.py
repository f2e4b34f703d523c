"""`device read WHERE [DEVICE]`: objects or registers once, raw and in engineering units."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from daemon.cli.connection import add_json_option
from daemon.cli.devices.words import add_device

if TYPE_CHECKING:
    from daemon.cli.devices.device_numbers import DeviceNumber


def options(parser: argparse.ArgumentParser) -> None:
    parser.description = "Show the objects of a CANopen node (SDO reads alone) or the registers of a Modbus unit. Nothing is written."
    add_device(parser)
    add_json_option(parser)
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    from config.errors import DriverError
    from daemon.cli.devices.device_numbers import device
    from daemon.cli.shown.terminal import text_table

    with device(arguments) as found:
        values = found.source.read()
        problems = found.source.problems()
    if all(value is None for value in values):
        raise DriverError("nothing could be read", value="; ".join(problems), where=found.title)
    if arguments.json:
        listed = [_as_dict(number, value) for number, value in zip(found.numbers, values, strict=True)]
        print(json.dumps({"device": found.title, "places": listed, "problems": problems}))
        return 0
    print(found.title)
    rows = [[number.where, number.name, number.type, *shown(number, value)] for number, value in zip(found.numbers, values, strict=True)]
    print("\n".join(text_table(["place", "name", "type", "raw", "value", "unit", "signal"], rows, left=(0, 1, 2, 5, 6))))
    for problem in problems:
        print(problem)
    return 0


def shown(number: DeviceNumber, value: float | str | None) -> list[str]:
    """Raw, engineering value, unit, signal."""
    if value is None:
        return ["no value", "", "", number.scaling.signal if number.scaling else ""]
    raw = f"{value:.10g}" if isinstance(value, float) else value
    if number.scaling is None or isinstance(value, str):
        return [raw, "", "", ""]
    return [raw, f"{number.scaling.value(value):.6g}", number.scaling.shown[0], number.scaling.signal]


def _as_dict(number: DeviceNumber, value: float | str | None) -> dict[str, Any]:
    row: dict[str, Any] = {"place": number.where, "name": number.name, "type": number.type, "raw": value}
    if number.scaling is not None:
        scaled = number.scaling.value(value) if isinstance(value, float) else None
        row |= {"signal": number.scaling.signal, "value": scaled, "unit": number.scaling.shown[0]}
    return row
