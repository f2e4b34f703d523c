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

if TYPE_CHECKING:
    from daemon.cli.devices.places import Place, ReadDevice
    from drivers.inspection.statistics import Statistics


def options(parser: argparse.ArgumentParser) -> None:
    parser.description = "Read a device again and again until Ctrl-C; statistics are in engineering units where the rig file has them."
    add_device(parser)
    parser.add_argument("--every", default="0.1 s", metavar="TIME", help="pause between two readings (default 0.1 s)")
    parser.add_argument("--for", dest="seconds", metavar="TIME", help="end after so long")
    add_json_option(parser)
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    from config.units import to_si
    from daemon.cli.devices.places import device

    every_s = to_si(arguments.every, "s")
    seconds = to_si(arguments.seconds, "s") if arguments.seconds else float("inf")
    with device(arguments) as found:
        return _watch(found, every_s, time.monotonic() + seconds, as_json=arguments.json)


def _watch(found: ReadDevice, every_s: float, end: float, *, as_json: bool) -> int:
    """Until `end` or Ctrl-C; both are an orderly end."""
    from daemon.cli.shown.terminal import LiveScreen
    from drivers.inspection.statistics import Statistics

    statistics = [Statistics() for _ in found.places]
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
                    screen.update([found.title, *_table(found.places, values, statistics), *found.source.problems()])
                else:
                    print(_printed(found, values, statistics, began - started, as_json=as_json), flush=True)
                if time.monotonic() + every_s >= end:
                    break
                time.sleep(max(0.0, began + every_s - time.monotonic()))
        if values and not live and not as_json:
            screen.update(_table(found.places, values, statistics))
    return 0


def _read(found: ReadDevice, statistics: list[Statistics]) -> list[float | str | None]:
    """One reading, counted in."""
    values = found.source.read()
    for place, value, kept in zip(found.places, values, statistics, strict=True):
        if isinstance(value, float):
            kept.take(place.scaling.value(value) if place.scaling else value)
    return values


def _table(places: list[Place], values: list[float | str | None], statistics: list[Statistics]) -> list[str]:
    from daemon.cli.shown.terminal import text_table

    headings = ["place", "name", "raw", "value", "unit", "min", "max", "mean", "sd", "readings"]
    rows = []
    for place, value, kept in zip(places, values, statistics, strict=True):
        raw, scaled, unit, _ = shown(place, value)
        numbers = [f"{number:.6g}" for number in (kept.least, kept.greatest, kept.mean, kept.sd)] if kept.count else [""] * 4
        rows.append([place.where, place.name, raw, scaled, unit, *numbers, str(kept.count)])
    return text_table(headings, rows, left=(0, 1, 4))


def _printed(found: ReadDevice, values: list[float | str | None], statistics: list[Statistics], at_s: float, *, as_json: bool) -> str:
    return _json_line(found, values, statistics, at_s) if as_json else _line(found.places, values, at_s)


def _line(places: list[Place], values: list[float | str | None], at_s: float) -> str:
    parts = []
    for place, value in zip(places, values, strict=True):
        raw, scaled, unit, _ = shown(place, value)
        parts.append(f"{place.name or place.where} {raw}" + (f" = {scaled} {unit}" if scaled else ""))
    return f"{at_s:8.2f} s  " + "  ".join(parts)


def _json_line(found: ReadDevice, values: list[float | str | None], statistics: list[Statistics], at_s: float) -> str:
    places = []
    for place, value, kept in zip(found.places, values, statistics, strict=True):
        row = {"place": place.where, "name": place.name, "raw": value, "readings": kept.count}
        if place.scaling is not None:
            row |= {"signal": place.scaling.signal, "unit": place.scaling.shown[0]}
            row["value"] = place.scaling.value(value) if isinstance(value, float) else None
        if kept.count:
            row |= {"min": kept.least, "max": kept.greatest, "mean": kept.mean, "sd": kept.sd if kept.count > 1 else None}
        places.append(row)
    return json.dumps({"t_s": round(at_s, 6), "places": places, "problems": found.source.problems()})
