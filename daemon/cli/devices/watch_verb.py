"""`device watch WHERE [DEVICE]`: live values with least, greatest, mean and standard deviation since the start."""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
import time
from typing import TYPE_CHECKING

from daemon.cli.connection import add_json_option
from daemon.cli.devices.read_verb import shown
from daemon.cli.devices.words import add_device
from daemon.cli.options.numbers import pause_s

if TYPE_CHECKING:
    from daemon.cli.devices.device_numbers import DeviceNumber, ReadDevice
    from drivers.inspection.statistics import Statistics


def options(parser: argparse.ArgumentParser) -> None:
    parser.description = "Read a device again and again until Ctrl-C; statistics are in engineering units where the rig file has them."
    add_device(parser)
    parser.add_argument("--every", type=pause_s, default="0.1 s", metavar="TIME", help="pause between two readings (default 0.1 s)")
    parser.add_argument("--for", dest="seconds", metavar="TIME", help="end after so long")
    add_json_option(parser)
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    from config.units import to_si
    from daemon.cli.devices.device_numbers import device

    seconds = to_si(arguments.seconds, "s") if arguments.seconds else float("inf")
    with device(arguments) as found:
        return _watch(found, arguments.every, time.monotonic() + seconds, as_json=arguments.json)


def _watch(found: ReadDevice, every_s: float, end: float, *, as_json: bool) -> int:
    """Until `end` or Ctrl-C; both are an orderly end."""
    from daemon.cli.shown.terminal import LiveScreen
    from drivers.inspection.statistics import Statistics

    statistics = [Statistics() for _ in found.numbers]
    live = sys.stdout.isatty() and not as_json
    if not live and not as_json:
        print(found.title, flush=True)
    started = time.monotonic()
    values: list[float | str | None] = []
    with LiveScreen() as screen:
        with contextlib.suppress(KeyboardInterrupt):
            while True:
                began = time.monotonic()
                values = _read(found, statistics)
                if live:
                    screen.update([found.title, *_table(found.numbers, values, statistics), *found.source.problems()])
                else:
                    print(_printed(found, values, statistics, began - started, as_json=as_json), flush=True)
                if time.monotonic() + every_s >= end:
                    break
                time.sleep(max(0.0, began + every_s - time.monotonic()))
        if values and not live and not as_json:
            screen.update(_table(found.numbers, values, statistics))
    return 0


def _read(found: ReadDevice, statistics: list[Statistics]) -> list[float | str | None]:
    """One reading, counted in."""
    values = found.source.read()
    for number, value, kept in zip(found.numbers, values, statistics, strict=True):
        if isinstance(value, float):
            kept.take(number.scaling.value(value) if number.scaling else value)
    return values


def _table(numbers: list[DeviceNumber], values: list[float | str | None], statistics: list[Statistics]) -> list[str]:
    from daemon.cli.shown.terminal import text_table

    headings = ["place", "name", "raw", "value", "unit", "min", "max", "mean", "sd", "readings"]
    rows = []
    for number, value, kept in zip(numbers, values, statistics, strict=True):
        raw, scaled, unit, _ = shown(number, value)
        spread = [f"{each:.6g}" for each in (kept.least, kept.greatest, kept.mean, kept.sd)] if kept.count else [""] * 4
        rows.append([number.where, number.name, raw, scaled, unit, *spread, str(kept.count)])
    return text_table(headings, rows, left=(0, 1, 4))


def _printed(found: ReadDevice, values: list[float | str | None], statistics: list[Statistics], at_s: float, *, as_json: bool) -> str:
    return _json_line(found, values, statistics, at_s) if as_json else _line(found.numbers, values, at_s)


def _line(numbers: list[DeviceNumber], values: list[float | str | None], at_s: float) -> str:
    parts = []
    for number, value in zip(numbers, values, strict=True):
        raw, scaled, unit, _ = shown(number, value)
        parts.append(f"{number.name or number.where} {raw}" + (f" = {scaled} {unit}" if scaled else ""))
    return f"{at_s:8.2f} s  " + "  ".join(parts)


def _json_line(found: ReadDevice, values: list[float | str | None], statistics: list[Statistics], at_s: float) -> str:
    rows = []
    for number, value, kept in zip(found.numbers, values, statistics, strict=True):
        row = {"place": number.where, "name": number.name, "raw": value, "readings": kept.count}
        if number.scaling is not None:
            row |= {"signal": number.scaling.signal, "unit": number.scaling.shown[0]}
            row["value"] = number.scaling.value(value) if isinstance(value, float) else None
        if kept.count:
            row |= {"min": kept.least, "max": kept.greatest, "mean": kept.mean, "sd": kept.sd if kept.count > 1 else None}
        rows.append(row)
    return json.dumps({"t_s": round(at_s, 6), "places": rows, "problems": found.source.problems()})
