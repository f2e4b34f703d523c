"""What the demo tells: before it begins, while it runs, and at its end with the three commands to type next."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

from config.loading.load import LoadedRig
from config.loading.stated_units import conversions, stated_units
from config.schema.rig import Rig
from daemon.cli.demo.demo_report import DemoReport
from daemon.cli.operate.measured_rate import is_simulated
from daemon.cli.operate.status_commands import status_view
from daemon.cli.refusal import program
from daemon.cli.shown.rich_console import console
from daemon.cli.shown.terminal import LiveScreen


def first_screen(rig: Rig, filters: Sequence[str], out: Path) -> str:
    """What will happen and how long it takes."""
    simulated = is_simulated(rig)
    moves = (
        "No hardware moves. Ctrl-C ends it." if simulated else "The hardware of this rig MOVES. Ctrl-C ends it; keep the e-stop at hand."
    )
    return (
        f"The paper's straight line on {'the simulated ' if simulated else ''}{rig.name}, {len(filters)} times: {', '.join(filters)}.\n"
        f"  what for       {filters[0]}, the link swings on after each move; the command filters of the other runs prevent it\n"
        "  what happens   the arm is armed, announces its motion, moves 30 in right, 60 in left, 30 in back, and is disarmed\n"
        "  how long       a minute and a half on the wall clock, less than a minute in lockstep (simulated time);\n"
        "                 the first run on a computer compiles the simulation first: up to a minute more\n"
        f"  what you get   a table of how much the tip still shakes after each move; logs and a plot in {out}/\n"
        f"{moves}"
    )


def last_screen(report: DemoReport) -> None:
    """What was seen, what the machine spoiled, and the next commands."""
    screen = console()
    screen.print(report.vibration_table())
    if (timing := report.timing_table()) is not None:
        screen.print(timing)
    for name, text in report.replays.items():
        print(f"{name}: re-executed from its log: {text}")
    print(f"plot: {report.plot}")
    for name, why in report.spoiled.items():
        print(f"{name} was repeated in lockstep, because the machine spoiled it on the wall clock: {why}")
    best = list(report.logs.values())[-1]
    print(f"seen: {report.seen()}\n\nnext:")
    for command, what in (
        (f"{program()} log info {best}", "rig, run, timing and predicted vibration, from the log alone"),
        (f"{program()} log plot {best}", "joints, commands, tip and pressures as a picture"),
        (f"{program()}d ornl_testbed", f"the same rig for maneuvers of your own; then, in another terminal: {program()} why"),
    ):
        print(f"  {command}\n      {what}")


class DemoScreen:
    """Lines to keep, and under them what changes. `quiet` tells nothing."""

    def __init__(self, rig: LoadedRig, quiet: bool) -> None:
        self._quiet = quiet
        joints = {name: joint.position_unit for name, joint in rig.rig.joints.items()}
        self._units = conversions(joints, stated_units(rig.text))
        self._live = LiveScreen()

    def say(self, line: str) -> None:
        """A line that stays."""
        if not self._quiet:
            self._live.update([])
            print(line, flush=True)

    def status(self, status: dict[str, Any]) -> None:
        """What the daemon says now."""
        self._show(status_view(status, self._units))

    def share(self, elapsed_s: float, duration_s: float) -> None:
        """How far a run in lockstep is."""
        self._show([f"{elapsed_s:.1f} of {duration_s:.1f} s of motion"])

    def _show(self, lines: list[str]) -> None:
        if not self._quiet:
            self._live.update(lines)

    def __enter__(self) -> DemoScreen:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._show([])
