"""`host`: measures how late this computer wakes the loop up, says which rates it keeps and what makes it late."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from contextlib import nullcontext
from typing import TYPE_CHECKING

from config.errors import EXIT_REFUSED, LogError
from daemon.cli.connection import add_json_option
from daemon.cli.number_option import finite

if TYPE_CHECKING:
    from config.schema.rig import Loop
    from daemon.host.causes import Cause
    from daemon.host.kept_grade import HostGrade
    from daemon.host.wake_ups import Machine

RATES_HZ = (250.0, 500.0, 1000.0, 2000.0, 4000.0)


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--rig", default="ornl_testbed", help="whose `loop` section is asked for (default ornl_testbed)")
    parser.add_argument("--seconds", type=finite(0.5, 3600, "s"), default=4.0, metavar="S", help="measured at each rate (default 4)")
    parser.add_argument("--load", action="store_true", help="beside a process on every processor that computes without a pause")
    add_json_option(parser)
    parser.set_defaults(run_command=_host)


def _host(arguments: argparse.Namespace) -> int:
    from datetime import UTC, datetime

    from config.loading.load import load_rig
    from daemon.host.busy_processors import busy_processors
    from daemon.host.causes import causes, stolen_ticks
    from daemon.host.host_facts import host
    from daemon.host.kept_grade import HostGrade, wishes_of

    loop = load_rig(arguments.rig).rig.loop
    before = stolen_ticks()
    with busy_processors() if arguments.load else nullcontext():
        seen = [_measured(loop, rate, arguments.seconds) for rate in sorted({*RATES_HZ, loop.rate_Hz})]
    after = stolen_ticks()
    looked_at = causes(stolen=(after[0] - before[0]) / max(after[1] - before[1], 1))
    kept = [machine for machine in seen if machine.keeps_rate]
    keeps = any(machine.wishes.rate_Hz == loop.rate_Hz for machine in kept)
    if arguments.json:
        print(json.dumps(_as_dict(seen, looked_at)))
    else:
        _print(seen, looked_at, arguments.rig, loop.rate_Hz)
    _keep(HostGrade(_grade(seen), f"{datetime.now(UTC):%Y-%m-%d %H:%M}", arguments.load, host(), wishes_of(loop)))
    return 0 if keeps else EXIT_REFUSED


def _measured(loop: Loop, rate_Hz: float, seconds: float) -> Machine:
    from daemon.host.wake_ups import measure

    print(f"measuring {rate_Hz:g} Hz for {seconds:g} s", file=sys.stderr, flush=True)
    return measure(loop, rate_Hz, seconds)


def _keep(grade: HostGrade) -> None:
    """What was found is true whether it can be kept or not."""
    from daemon.host.kept_grade import keep

    try:
        path = keep(grade)
    except LogError as refused:
        print(f"not kept for the daemon: {refused}", file=sys.stderr)
    else:
        print(f"kept in {path}: the daemon reads it (loop.demand_rate)", file=sys.stderr)


def _as_dict(seen: list[Machine], looked_at: list[Cause]) -> dict[str, object]:
    rates = [dataclasses.asdict(machine) | {"keeps_rate": machine.keeps_rate} for machine in seen]
    return {"grade_Hz": _grade(seen), "rates": rates, "causes": [dataclasses.asdict(cause) for cause in looked_at]}


def _grade(seen: list[Machine]) -> float:
    """The highest rate up to which every rate is kept; 0: none."""
    grade = 0.0
    for machine in seen:
        if not machine.keeps_rate:
            return grade
        grade = machine.wishes.rate_Hz
    return grade


def _print(seen: list[Machine], looked_at: list[Cause], rig: str, wanted_Hz: float) -> None:
    from daemon.cli.shown.terminal import text_table

    head = ["rate, Hz", "woken late p50, us", "p99", "p99.9", "largest, ms", "overruns", "keeps it"]
    print("\n".join(text_table(head, [_row(machine) for machine in seen])))
    found = [[cause.name, cause.value, cause.next_step or "-"] for cause in looked_at]
    found += [["refused", refused, "Run it as the service, which has these rights."] for refused in seen[-1].refused]
    print("\n" + "\n".join(text_table(["what", "found", "to do"], found, left=(0, 1, 2))) + "\n")
    grade = _grade(seen)
    advice = "longreach demo" if grade >= wanted_Hz else "do what stands above, then longreach host again"
    print(f"this computer keeps {grade:g} Hz; {rig} asks for {wanted_Hz:g} Hz. Next: {advice}")


def _row(machine: Machine) -> list[str]:
    late = [f"{1e6 * value:.0f}" for value in (machine.late_p50_s, machine.late_p99_s, machine.late_p999_s)]
    over = f"{machine.overruns} of {machine.cycles}"
    return [f"{machine.wishes.rate_Hz:g}", *late, f"{1e3 * machine.largest_s:.1f}", over, "yes" if machine.keeps_rate else "no"]
