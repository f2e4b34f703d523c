"""`host`: measures the daemon on this computer at several rates, says which it keeps and what makes it late."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from contextlib import nullcontext
from typing import TYPE_CHECKING

from config.errors import EXIT_REFUSED, ConfigError, LogError
from daemon.cli.connection import add_json_option
from daemon.cli.options.numbers import finite

if TYPE_CHECKING:
    from config.loading.load import LoadedRig
    from daemon.host.causes import Cause
    from daemon.host.kept_grade import HostGrade
    from daemon.host.rate_seen import RateSeen

RATES_HZ = (250.0, 500.0, 1000.0, 2000.0)


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--rig", default="ornl_testbed", help="whose loop and devices; real ones keep safe outputs (default ornl_testbed)")
    parser.add_argument("--seconds", type=finite(0.5, 3600, "s"), default=4.0, metavar="S", help="measured at each rate (default 4)")
    parser.add_argument("--load", action="store_true", help="beside a process on every processor that computes without a pause")
    add_json_option(parser)
    parser.set_defaults(run_command=_host)


def _host(arguments: argparse.Namespace) -> int:
    from datetime import UTC, datetime

    from config.loading.load import load_rig
    from daemon.host.busy_processors import busy_processors
    from daemon.host.causes import causes, stolen_ticks
    from daemon.host.kept_grade import HostGrade, measured_for

    loaded = load_rig(arguments.rig)
    rate_Hz = loaded.rig.loop.rate_Hz
    before = stolen_ticks()
    with busy_processors() if arguments.load else nullcontext():
        seen, unable = _measured(loaded, arguments.seconds)
    after = stolen_ticks()
    looked_at = causes(stolen=(after[0] - before[0]) / max(after[1] - before[1], 1))
    if arguments.json:
        print(json.dumps(_as_dict(seen, unable, looked_at)))
    else:
        _print(seen, unable, looked_at, arguments.rig, rate_Hz)
    refused = tuple(sorted({each.partition(":")[0] for one in seen for each in one.refused}))
    _keep(HostGrade(_grade(seen), f"{datetime.now(UTC):%Y-%m-%d %H:%M}", arguments.load, refused, measured_for(loaded.rig)))
    return 0 if any(one.keeps_rate and one.rate_Hz == rate_Hz for one in seen) else EXIT_REFUSED


def _measured(loaded: LoadedRig, seconds: float) -> tuple[list[RateSeen], str]:
    """Every rate from the lowest on, and why there are no higher ones: some a rig cannot have, because its bus is too slow for instance."""
    from daemon.cli.operate.measured_rate import measure

    seen: list[RateSeen] = []
    for rate_Hz in sorted({*RATES_HZ, loaded.rig.loop.rate_Hz}):
        print(f"measuring {rate_Hz:g} Hz for {seconds:g} s", file=sys.stderr, flush=True)
        try:
            seen.append(measure(loaded, rate_Hz, seconds))
        except ConfigError as error:
            if rate_Hz <= loaded.rig.loop.rate_Hz:
                raise
            return seen, f"{rate_Hz:g} Hz: {error}"
    return seen, ""


def _keep(grade: HostGrade) -> None:
    """What was found is true whether it can be kept or not."""
    from daemon.host.kept_grade import keep

    try:
        path = keep(grade)
    except LogError as refused:
        print(f"not kept for the daemon: {refused}", file=sys.stderr)
    else:
        print(f"kept in {path}: the daemon reads it (loop.demand_rate)", file=sys.stderr)


def _as_dict(seen: list[RateSeen], unable: str, looked_at: list[Cause]) -> dict[str, object]:
    rates = [dataclasses.asdict(one) | {"keeps_rate": one.keeps_rate} for one in seen]
    return {"grade_Hz": _grade(seen), "rates": rates, "no_higher": unable, "causes": [dataclasses.asdict(cause) for cause in looked_at]}


def _grade(seen: list[RateSeen]) -> float:
    """The highest rate up to which every rate is kept; 0: none."""
    grade = 0.0
    for one in seen:
        if not one.keeps_rate:
            return grade
        grade = one.rate_Hz
    return grade


def _print(seen: list[RateSeen], unable: str, looked_at: list[Cause], rig: str, wanted_Hz: float) -> None:
    from daemon.cli.shown.terminal import text_table

    head = ["rate, Hz", "woken late p50, us", "p99", "p99.9", "work p99, us", "latest, ms", "overruns", "keeps it"]
    print("\n".join([*text_table(head, [_row(one) for one in seen]), *([f"no higher rate: {unable}"] if unable else [])]))
    works = "armed and held on simulated devices" if seen[-1].held else "devices read, outputs safe"
    found = [["longreachd", f"{rig}: {works}", "-"]]
    found += [[cause.name, cause.value, cause.next_step or "-"] for cause in looked_at]
    found += [["refused", refused, "Run it as the service, which has these rights."] for refused in seen[-1].refused]
    print("\n" + "\n".join(text_table(["what", "found", "to do"], found, left=(0, 1, 2))) + "\n")
    grade = _grade(seen)
    advice = "longreach demo" if seen[-1].held else f"longreach commission {rig}"
    advice = advice if grade >= wanted_Hz else "do what stands above, then longreach host again"
    print(f"this computer keeps {grade:g} Hz; {rig} asks for {wanted_Hz:g} Hz. Next: {advice}")


def _row(one: RateSeen) -> list[str]:
    times = [f"{1e6 * value:.0f}" for value in (one.late_p50_s, one.late_p99_s, one.late_p999_s, one.work_p99_s)]
    over = f"{one.overruns} of {one.cycles}" + (f", {one.lost} lost" if one.lost else "")
    return [f"{one.rate_Hz:g}", *times, f"{1e3 * one.largest_s:.1f}", over, "yes" if one.keeps_rate else "no"]
