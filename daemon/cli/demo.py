"""`demo`: the paper's straight-line maneuver on the simulated Oak Ridge test bed, unshaped and with two command filters.

Every run starts from the same state, in a daemon of its own, through the same driver contract, recorder and log as on a rig; the report is
made from the logs alone.
"""

from __future__ import annotations

import argparse
import json
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from rich.live import Live

from config.load import load_rig
from config.shipped import find
from daemon.cli.check_table import console
from daemon.cli.connection import add_json_option
from daemon.cli.demo_report import DemoReport, make_report
from daemon.cli.demo_session import wall_clock_runs
from daemon.cli.status_commands import status_view
from daemon.lockstep import run_lockstep

FILTERS: dict[str, dict[str, Any]] = {
    "unshaped": {"kind": "none"},
    "three-term": {"kind": "three_term", "focal": "mid"},
    "adaptive": {"kind": "adaptive"},
}


def register(commands: Any) -> None:
    parser = commands.add_parser("demo", help="run the paper's maneuver on the simulated rig, unshaped and shaped, and report")
    parser.add_argument("--lockstep", action="store_true", help="as fast as the computer can, not on the wall clock")
    parser.add_argument("--out", type=Path, default=Path("demo"), metavar="DIR", help="where logs and plots go (default ./demo)")
    parser.add_argument("--rig", default="ornl_testbed", help="a rig with a simulated plant (default ornl_testbed)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change the maneuver, e.g. --set y0='30 in'")
    add_json_option(parser)
    parser.set_defaults(run_command=_demo)


def requests(parameters: list[str]) -> list[dict[str, Any]]:
    """The three runs, in the words of the daemon's `start` request."""
    common = {"maneuver": {"name": "paper_line"}, "parameters": parameters, "approach": True}
    return [{**common, "shaper": dict(shaper)} for shaper in FILTERS.values()]


def _demo(arguments: argparse.Namespace) -> int:
    arguments.out.mkdir(parents=True, exist_ok=True)
    rig_path = find("rigs", arguments.rig)
    runs = requests(arguments.set)
    quiet = arguments.json
    if not quiet:
        clock = "in lockstep" if arguments.lockstep else "on the wall clock"
        print(f"three runs of the paper's straight line on {rig_path.stem}, {clock}; logs go to {arguments.out}/")
    if arguments.lockstep:
        logs = [path for run in runs for path in run_lockstep(load_rig(rig_path), [run], arguments.out)]
    else:
        logs = _watched(rig_path, runs, arguments.out, quiet)
    report = make_report(dict(zip(FILTERS, logs, strict=True)), arguments.out)
    print(json.dumps(report.as_dict())) if quiet else _show(report)
    return 0 if report.all_identical else 1


def _watched(rig: Path, runs: list[dict[str, Any]], out: Path, quiet: bool) -> list[Path]:
    """Run on the wall clock with the live status screen."""
    with nullcontext() if quiet else Live(console=console(), refresh_per_second=10, transient=True) as live:
        return wall_clock_runs(rig, runs, out, lambda status: live.update(status_view(status)) if live else None)


def _show(report: DemoReport) -> None:
    screen = console()
    screen.print(report.vibration_table())
    screen.print(report.timing_table())
    for name, text in report.replays.items():
        print(f"{name}: re-executed from its log: {text}")
    print(f"plot: {report.plot}")
