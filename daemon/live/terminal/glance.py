"""One screen of text from what was received so far: mode, run, joints, tip, oil, checks that fail, newest events."""

from __future__ import annotations

import re
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from config.readable import number
from daemon.live.source.pending import Content

MODE_STYLES = {"holding": "cyan", "running": "green", "fault": "bold red", "arming": "yellow", "stopping": "yellow", "proving": "yellow"}
LEVEL_STYLES = {"warning": "yellow", "error": "red", "fault": "bold red"}
STALE_S = 1.5  # without a new cycle
SPARK = "▁▂▃▄▅▆▇█"
SPARK_WIDTH = 16
SAMPLES_A_STEP = 10  # a step of a spark line: a fifth of a second
CHECKS_SHOWN = 3
EVENTS_KEPT = 40
_UNIT = re.compile("_(V|Pa|C)$")  # at the end of a name
_OF_A_JOINT = ("position", "reference", "following_error", "velocity", "command_V")
_OF_OIL = ("supply_pressure_Pa", "return_pressure_Pa", "supply_temperature_C", "return_temperature_C")


class Glance:
    """`take` what the feed hands out; `lines` draws it."""

    def __init__(self) -> None:
        self._known: Content = {"lost": "connecting"}
        self._row: list[float | None] = []
        self._came_s = 0.0  # when the newest row came
        self._played = ""  # the log, where the rig is none that moves
        self._signals: dict[str, dict[str, Any]] = {}
        self._at: dict[str, int] = {}
        self._events: deque[dict[str, Any]] = deque(maxlen=EVENTS_KEPT)
        self._errors: dict[str, deque[float]] = {}

    def take(self, content: Content) -> None:
        if "rig" in content:
            self._begin(content["rig"])
        self._known.update(content)
        self._events.extend(content.get("events", ()))
        for row in content.get("samples", ()):
            self._row, self._came_s = row, time.monotonic()
            for joint, errors in self._errors.items():
                error = row[self._at[f"{joint}.following_error"]]
                errors.append(0.0 if error is None else abs(error))

    def _begin(self, rig: dict[str, Any]) -> None:
        self._row = []
        self._played = str(rig.get("played") or "")
        self._events.clear()
        self._signals = {signal["name"]: signal for signal in rig["signals"]}
        self._at = {signal["name"]: 1 + index for index, signal in enumerate(rig["signals"])}
        self._errors = {joint: deque(maxlen=SPARK_WIDTH * SAMPLES_A_STEP) for joint in rig["joints"]}

    def lines(self, height: int) -> RenderableType:
        """For a terminal of so many lines; what does not fit are the oldest events."""
        parts: list[Text | Table] = [*self._head(), *self._loop()]
        if lost := self._lost():
            parts.append(Text(f"NO LIVE DATA: {lost}", "bold red"))
        if self._row:
            parts += [self._table("joint", _OF_A_JOINT, self._spark, "error, 3 s"), self._table("oil", _OF_OIL), self._tip()]
        parts += self._checks()
        left = height - sum(part.row_count + 1 if isinstance(part, Table) else 1 for part in parts) - 1
        newest = list(self._events)[-max(0, left) :] if left > 0 else []
        parts += [_clipped(f"{each['t_s']:9.3f} s  {each['text']}", LEVEL_STYLES.get(each["level"], "dim")) for each in newest]
        stops = "" if self._played else "   stop: longreach stop   e-stop: longreach estop"
        return Group(*parts, _clipped(f"q: leave{stops}", "dim"))

    def _lost(self) -> str:
        """Why what is shown is not what is now; nothing while it is."""
        if self._known["lost"] or not self._row or time.monotonic() - self._came_s <= STALE_S:
            return str(self._known["lost"])
        return "the log has ended" if self._played else "the loop makes no new cycle"

    def _head(self) -> list[Text]:
        """A fault and a run have a line for themselves: whatever else is to be said, they are not what a narrow terminal cuts off."""
        status = self._known.get("status")
        if status is None:
            return [Text("longreach top", "bold")]
        mode = status["mode"]
        played = [_clipped(f"PLAYED from {self._played}, not the rig", "bold black on yellow")] if self._played else []
        rig = Text.assemble((status["rig"], "bold"), "  ", (mode.upper(), MODE_STYLES.get(mode, "bold")), f"  e-stop {status['estop']}")
        fault = status["fault"]
        run = _clipped(f"fault: {fault['text']}", LEVEL_STYLES["fault"]) if fault else _clipped(_run_line(status["run"]))
        return [*played, _one_line(rig), run]

    def _loop(self) -> list[Text]:
        status = self._known.get("status")
        if status is None:
            return []
        loop = status["loop"]
        late = number(float(loop["late_us_p99"] or 0.0))
        counts = f"overruns {loop['overruns']}  drops {loop['drops']}"
        return [_clipped(f"cycle {status['cycle']}  {loop['rate_Hz']:g} Hz  late p99 {late} us  {counts}")]

    def _table(self, title: str, names: Sequence[str], last: Callable[[str], str] | None = None, heading: str = "") -> Table:
        """A row a joint; its columns are those that the rig has."""
        shown = [name for name in names if any(f"{joint}.{name}" in self._at for joint in self._errors)]
        table = Table(box=None, padding=(0, 1), pad_edge=False, header_style="bold")
        table.add_column(title, no_wrap=True, min_width=max(map(len, self._errors)))
        for name in shown:
            table.add_column(_UNIT.sub("", name).replace("_", " "), justify="right", no_wrap=True)
        if last is not None:
            table.add_column(heading)
        for joint in self._errors:
            cells = [self._shown(f"{joint}.{name}") for name in shown]
            table.add_row(joint, *cells, *([last(joint)] if last is not None else []))
        return table

    def _tip(self) -> Text:
        names = {"tip.acceleration_mps2": "tip acceleration", "tip.deflection_m": "deflection", "reservoir_temperature_C": "reservoir"}
        return _clipped("  ".join(f"{title} {self._shown(name)}" for name, title in names.items() if name in self._at))

    def _checks(self) -> list[Text]:
        checks = self._known.get("checks", [])
        failed = [check for check in checks if check["ok"] is False]
        if not failed:
            return [_clipped(f"{len(checks)} checks: nothing stands in the way", "green")] if checks else []
        lines = [_clipped(f"{len(failed)} of {len(checks)} checks stand in the way: longreach why", "bold red")]
        for check in failed[:CHECKS_SHOWN]:
            value = f"{number(check['value'])} {check['unit'] or ''}".strip()
            lines.append(_clipped(f"NO {check['name']}: {value} (limit {check['limit']}). {check['next_step']}", "red"))
        return lines

    def _shown(self, name: str) -> str:
        """The newest value in the unit of the rig file."""
        value = self._row[self._at[name]] if name in self._at else None
        if value is None:
            return "–"
        signal = self._signals[name]
        return f"{signal['factor'] * value + signal['offset']:.3f} {signal['unit']}"

    def _spark(self, joint: str) -> str:
        """The last three seconds of the following error over their largest."""
        errors = list(self._errors[joint])
        steps = [max(errors[k : k + SAMPLES_A_STEP]) for k in range(0, len(errors), SAMPLES_A_STEP)]
        largest = max(steps, default=0.0) or 1.0
        return "".join(SPARK[min(len(SPARK) - 1, int(len(SPARK) * step / largest))] for step in steps)


def _run_line(run: dict[str, Any] | None) -> str:
    if run is None:
        return "no run yet"
    if run["countdown_s"] > 0.0:
        return f"run {run['run']}: {run['maneuver']}: MOTION STARTS IN {run['countdown_s']:.0f} s"
    reason = f", because {run['reason']}" if run["reason"] else ""
    of = "" if run["duration_s"] is None else f" of {run['duration_s']:.1f}"  # driven by hand: nobody knows
    return f"run {run['run']}: {run['maneuver']}, {run['elapsed_s']:.1f}{of} s, {run['validity']}{reason}"


def _clipped(text: str, style: str = "") -> Text:
    return _one_line(Text(text, style))


def _one_line(text: Text) -> Text:
    text.no_wrap, text.overflow = True, "ellipsis"
    return text
