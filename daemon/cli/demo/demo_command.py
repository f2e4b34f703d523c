"""`demo`: the paper's straight-line maneuver on the simulated Oak Ridge test bed, unshaped and with two command filters.

Every run starts from the same state, in a daemon of its own, through the same driver contract, recorder and log as on a rig; the report is
made from the logs alone.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import EXIT_REFUSED, DaemonError, ManeuverError
from daemon.cli.connection import add_json_option
from daemon.cli.shown.shown_units import stated_refusals

if TYPE_CHECKING:
    from config.loading.load import LoadedRig
    from config.schema.rig import Rig

FILTERS: dict[str, dict[str, Any]] = {
    "unshaped": {"kind": "none"},
    "three-term": {"kind": "three_term", "focal": "mid"},
    "adaptive": {"kind": "adaptive"},
}


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--lockstep", action="store_true", help="as fast as the computer can, on simulated time, whatever the machine")
    parser.add_argument("--out", type=Path, default=Path("demo"), metavar="DIR", help="where logs and plots go (default ./demo)")
    parser.add_argument("--rig", default="ornl_testbed", help="a rig with a simulated plant (default ornl_testbed)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change the maneuver, e.g. --set y0='30 in'")
    add_json_option(parser)
    parser.set_defaults(run_command=_demo)


def requests(parameters: list[str]) -> dict[str, dict[str, Any]]:
    """The three runs by their filters' names, in the words of the daemon's `start` request."""
    common = {"maneuver": {"name": "paper_line"}, "parameters": parameters, "approach": True}
    return {name: {**common, "shaper": dict(shaper)} for name, shaper in FILTERS.items()}


def _demo(arguments: argparse.Namespace) -> int:
    from config.loading.load import load_rig
    from config.loading.stand_in import with_simulated_devices
    from daemon.cli.demo.demo_report import make_report
    from daemon.cli.demo.demo_runs import DemoRuns
    from daemon.cli.demo.demo_screen import DemoScreen, first_screen, last_screen

    rig = with_simulated_devices(load_rig(arguments.rig)) if arguments.lockstep else load_rig(arguments.rig)
    runs = requests(arguments.set)
    with stated_refusals(rig.text, si=arguments.json):
        _refuse_impossible(rig.rig, runs, own_maneuver=bool(arguments.set))
    arguments.out.mkdir(parents=True, exist_ok=True)
    with DemoScreen(rig, quiet=arguments.json) as screen:
        screen.say(first_screen(rig.rig, list(runs), arguments.out))
        done = DemoRuns(rig, arguments.out, screen, _why_lockstep(arguments, rig, screen.say))
        with stated_refusals(rig.text, si=arguments.json):
            done.run(runs)
        screen.say("reading the logs: vibration, and the controller executed again, bit for bit")
        report = make_report(done, arguments.out)
    print(json.dumps(report.as_dict())) if arguments.json else last_screen(report)
    return 0 if report.all_identical else EXIT_REFUSED


def _refuse_impossible(rig: Rig, runs: Mapping[str, Mapping[str, Any]], own_maneuver: bool) -> None:
    """What this rig cannot run is told before the machine is measured and a daemon started."""
    from daemon.server.start_request import start_run

    middle = [0.5 * sum(joint.travel) for joint in rig.joints.values()]
    try:
        for request in runs.values():
            start_run(rig, 1, request, middle)
    except (ManeuverError, DaemonError) as error:
        if error.refusal.mend:
            raise
        parts = error.refusal
        ends = "" if own_maneuver else "`longreach demo` runs on the shipped testbed."
        raise ManeuverError(
            parts.what,
            value=parts.value,
            limit=parts.limit,
            unit=parts.unit,
            where=parts.where,
            next_step=f"{parts.next_step} {ends}".strip(),
        ) from error


def _why_lockstep(arguments: argparse.Namespace, loaded: LoadedRig, say: Callable[[str], None]) -> str:
    """Why the runs are not on the wall clock; empty when they are. A rig with hardware is never put off."""
    from daemon.cli.operate.measured_rate import is_simulated, measure
    from daemon.host.rate_seen import MEASURED_S

    if arguments.lockstep:
        return "asked for with --lockstep"
    if not is_simulated(loaded.rig):
        return ""
    say(f"measuring this machine for {MEASURED_S:g} s")
    try:
        seen = measure(loaded)
    except DaemonError as error:
        say(f"{error}: in lockstep, on simulated time")
        return f"the machine could not be measured: {error}"
    say(seen.text())
    why = "" if seen.keeps_rate else f"this machine does not keep {seen.rate_Hz:.0f} Hz now"
    say(f"{why}: in lockstep, on simulated time" if why else "this machine keeps the rate: on the wall clock")
    return why
