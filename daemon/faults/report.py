"""The fault matrix as a table for people and as a page for docs/."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from textwrap import fill

from rich.table import Table

from daemon.faults.benches.process_bench import SPEED as PROCESSES
from daemon.faults.benches.twin_bench import FORGIVEN_FRAMES
from daemon.faults.benches.twin_bench import SPEED as TWIN
from daemon.faults.fault import NEVER_MS, FaultRow, Until
from daemon.faults.process_faults import REQUEST_MS

_HEADINGS = ("fault", "where", "reaction", "time to", "median ms", "worst ms", "limit ms", "trials")
WIDTH = 110  # of a line of prose
_ALL = "All {} faults end as they must."
_EXPLANATION = f"""\
Every fault is injected while the arm moves, at a random instant. The time begins with the injection.

- where **loop**: sensors and drivers that are wrong; the daemon's loop in lockstep; the arm at 50 deg/s or 10
  in/s. The output register, read by code that knows nothing of the loop, says when the valves were safe.
- **processes**: a daemon with all its processes on the wall clock and the plant in it; {PROCESSES}. The
  output register again.
- **twin**: the same with `longreach twin`, CANopen and Modbus between them, each device with its own
  supervision; {TWIN}. The twin's valves say when their spools had arrived where the valve itself wants
  them.

What is measured:

- **{Until.SAFE}**: every output has its safe value, by a command or by the device's own time-out, and keeps
  it. "device time-out" in the reaction: a valve's own supervision has acted;
- **{Until.REST}**: every command is small and stays so, after a controlled stop in which the servo goes on
  acting;
- **{Until.RENEWED}**: nothing has to become safe; the time is the longest for which the outputs were not
  renewed.

A trial begins only when the daemon moves the arm without any complaint. What the machine does after the
injection is in the times.

## Limits

| limit | for |
|---|---|
| 20 ms | what the loop sees: from the fault to safe outputs |
| 100 ms | what only the motion shows, or the io process sees |
| 100 ms | in the twin, when host, process, bus or valve is gone: the devices' time-out of 60 ms |
| device time-out + 10 ms | the plant in the daemon; `devices.*.timeout` of the rig file is 70 ms; + 10 ms where processes end |
| {REQUEST_MS:.0f} ms | requests over the socket, and signals to the supervisor |
| 50 ms | pauses that the loop may have (`loop.overruns.fault_late`) |
| 5 s | a controlled stop (longer ones are faults), after the silence allowed to another process; for a gauge it begins within 20 ms |
| `max_age` of the signal + 20 ms | the thermometer; + 50 ms where the io process serves it, + 100 ms for a dead Modbus unit |

Lockstep time has no computing in it: a real cycle adds the microseconds of reading, checking and writing.
Wall-clock times contain what else the computer was doing. The wall clock is stepped for the daemon's
processes only, and ENOBUFS raised where Python hands a datagram to the kernel. In the twin rows a device is
silent after {FORGIVEN_FRAMES} missing frames instead of 3, and a position old after 12 ms instead of 5,
because a shared virtual machine stands still for 3 ms many times a minute: on a rig these faults are seen 2
ms sooner. A stuck encoder is seen when the reference has gone 0.1 following error limits further, so a slow
arm shows it later, and one that stands still never.
"""


def table(rows: Sequence[FaultRow]) -> Table:
    screen = Table("", *_HEADINGS, title="fault matrix")
    for row in rows:
        screen.add_row("ok" if row.ok else "NO", *cells(row), style=None if row.ok else "red")
    return screen


def cells(row: FaultRow) -> tuple[str, ...]:
    times = (_ms(row.median_ms), _ms(row.worst_ms), f"{row.fault.expected.limit_ms:.0f}", str(len(row.trials)))
    return row.fault.name, str(row.fault.where), row.reaction, str(row.fault.expected.until), *times


def page(rows: Sequence[FaultRow], command: str) -> str:
    """Markdown with the command that made it."""
    measured = [row for row in rows if not row.skipped]
    failed = [row.fault.name for row in measured if not row.ok]
    verdict = f"{len(failed)} of {len(measured)} do not end as they must: {', '.join(failed)}." if failed else _ALL.format(len(measured))
    if len(measured) < len(rows):
        verdict += f" {len(rows) - len(measured)} could not be injected here."
    lines = ["# The fault matrix", "", fill(f"Made by `{command}`. {verdict}", WIDTH, break_on_hyphens=False), ""]
    lines += [f"| {' | '.join(_HEADINGS)} | ok |", "|---|---|---|---|--:|--:|--:|--:|---|"]
    lines += [f"| {' | '.join(cells(row))} | {'ok' if row.ok else '**NO**'} |" for row in rows]
    return "\n".join([*lines, "", "## How it is measured", "", _EXPLANATION])


def _ms(value: float) -> str:
    return "never" if value == NEVER_MS else f"{value:.1f}" if isfinite(value) else "-"
