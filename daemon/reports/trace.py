"""One run of one log on the time axis of a report: 0 where the maneuver's program begins."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from config.errors import LongreachError
from config.stated_sentences import Conversion
from recording.evaluation.chosen_signals import ChosenSignal, in_unit
from recording.evaluation.panels import Line
from recording.evaluation.program_start import plan_of, program_start_s
from recording.evaluation.spectrum import hann_spectrum, without_gaps
from recording.evaluation.vibration import TIP, HoldVibration, hold_vibration
from recording.files.info import RunFacts, run_of
from recording.files.reader import Log
from servo_control.planning.run_plan import RunPlan
from servo_control.signals import Mode

AFTER_S = 2.0  # shown after the run's end
BAND_HZ = (0.5, 25.0)

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Trace:
    """`name` as in the legends: empty for the run the report is of. `units`: column → shown unit, of that run's rig file."""

    name: str
    log: Log
    run: int
    units: Mapping[str, Conversion]

    @cached_property
    def facts(self) -> RunFacts:
        return run_of(self.log, self.run)

    @cached_property
    def request(self) -> dict[str, object]:
        content: dict[str, object] = json.loads(self.log.attachments.get(f"run-{self.run}.json", b"{}"))
        return content

    @cached_property
    def plan(self) -> RunPlan | None:
        return plan_of(self.log, self.run)

    @cached_property
    def start_s(self) -> float:
        return program_start_s(self.log, self.run, self.plan)

    @cached_property
    def rows(self) -> slice:
        """The run, its approach, and a little more."""
        t = self.log.columns["t_s"]
        first, last = (np.searchsorted(t, moment) for moment in (self.facts.start_t_s, self.end_s + AFTER_S))
        return slice(int(first), int(last) + 1)

    @property
    def end_s(self) -> float:
        return self.facts.start_t_s + self.facts.duration_s

    @cached_property
    def holds(self) -> list[HoldVibration]:
        """Empty where the log says nothing about the tip."""
        try:
            return [hold for hold in hold_vibration(self.log) if hold.run == self.run]
        except LongreachError:
            return []

    def signal(self, column: str) -> ChosenSignal | None:
        """None where the log has no numbers for it in this run."""
        if column not in self.log.columns:
            return None
        signal = in_unit(self.log, column, self.rows, self.units)
        return signal if np.any(np.isfinite(signal.values)) else None

    def line(self, column: str, dashed: bool = False) -> Line | None:
        signal = self.signal(column)
        if signal is None:
            return None
        label = self.name or column.rpartition(".")[2].removesuffix("_mps2").removesuffix("_m")
        return Line(label, signal.t_s - self.start_s, signal.values, dashed or bool(self.name))

    def error(self, joint: str) -> Line | None:
        """Reference - position."""
        reference, position = self.signal(f"{joint}.reference"), self.signal(f"{joint}.position")
        if reference is None or position is None:
            return None
        return Line(self.name or "error", reference.t_s - self.start_s, reference.values - position.values, bool(self.name))

    def shaded(self) -> tuple[tuple[float, float], ...]:
        """The holds of the plan."""
        if self.plan is None:
            return ()
        zero = self.start_s - self.facts.start_t_s
        return tuple((s.start_s - zero, s.end_s - zero) for s in self.plan.segments if s.kind == "hold")

    def spectrum(self, number: int) -> Line | None:
        """Of the tip's acceleration in hold `number` (from 0) of the holds that were measured."""
        if number >= len(self.holds) or TIP not in self.log.columns:
            return None
        end = self.holds[number].end_t_s
        at = int(np.searchsorted(self.log.columns["t_s"], end + 1e-9))
        rows = np.flatnonzero(self._running & (self.log.columns["segment"] == self.log.columns["segment"][at]))
        signal = in_unit(self.log, TIP, slice(int(rows[0]), int(rows[-1]) + 1), self.units)
        frequency, amplitude = hann_spectrum(without_gaps(signal.values), float(np.median(np.diff(signal.t_s))))
        band = (frequency >= BAND_HZ[0]) & (frequency <= BAND_HZ[1])
        return Line(self.name or "measured", frequency[band], amplitude[band], bool(self.name))

    @cached_property
    def _running(self) -> npt.NDArray[np.bool_]:
        running: npt.NDArray[np.bool_] = (self.log.columns["maneuver"] == self.run) & (self.log.columns["mode"] == Mode.RUNNING)
        return running
