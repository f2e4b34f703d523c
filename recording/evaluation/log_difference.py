"""What differs between two logs: rig file, maneuver, filter, software; and every signal, aligned on where the program begins."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from config.errors import LongreachError
from config.parsing.yaml_tree import parse
from recording.evaluation.aligned_signals import NotCompared, aligned_signals, common_time
from recording.evaluation.chosen_signals import ChosenSignal
from recording.evaluation.panels import Line, Panel, label
from recording.evaluation.vibration import HoldVibration, hold_vibration
from recording.files.info import run_facts, run_of
from recording.files.reader import Log

FACTS = ("rig_name", "clock", "seed", "rate_Hz", "software_version", "software_commit", "host_name")
PANELS = 6  # of the picture


@dataclass(frozen=True, slots=True)
class ChangedValue:
    """A value that is not the same in both, as it was written; None where one log has none. `about`: rig, maneuver, filter, log."""

    about: str
    key: str
    a: Any
    b: Any

    def text(self) -> str:
        a, b = ("(none)" if value is None else value for value in (self.a, self.b))
        return f"{self.about:10}{self.key}: {a} → {b}"


@dataclass(frozen=True, slots=True)
class SignalDifference:
    """B - A over the common time of the two runs, in `unit`. `share`: rms of the difference over the rms of A about its mean (NaN: A does
    not move). `at_s`: time since the program began of the largest difference."""

    name: str
    unit: str
    rms: float
    largest: float
    at_s: float
    share: float


@dataclass(frozen=True, slots=True)
class LogDifference:
    """`overlap_s`: how long both runs last. `vibration`: m/s² of every hold, A and B, by the move's name."""

    runs: tuple[int, int]
    overlap_s: float
    changed: tuple[ChangedValue, ...]
    signals: tuple[SignalDifference, ...]
    not_compared: NotCompared
    vibration: dict[str, tuple[float | None, float | None]]
    pairs: dict[str, tuple[ChosenSignal, ChosenSignal]] = field(repr=False)

    @property
    def same(self) -> bool:
        """Nothing differs, and nothing of either run was left out of the comparison."""
        return bool(self.signals) and not (self.changed or self.not_compared or any(each.largest > 0.0 for each in self.signals))

    def text(self) -> str:
        lines = [f"run {self.runs[0]} of A beside run {self.runs[1]} of B, {self.overlap_s:.3f} s in common"]
        lines += [f"  {each.text()}" for each in self.changed] or ["  rig file, maneuver and filter are the same"]
        lines += [f"  {move}: vibration {_number(a)} → {_number(b)} m/s²" for move, (a, b) in self.vibration.items()]
        lines += [f"  {line}" for line in self.not_compared.lines()]
        moved = [each for each in self.signals if each.largest > 0.0]
        if not moved:
            return "\n".join([*lines, f"  {self._none_differs()}"])
        head = f"  {'signal':32}{'unit':10}{'rms B - A':>12}{'largest':>12}{'at / s':>9}{'share of A':>12}"
        rows = (
            f"  {label(s.name):32}{s.unit:10}{s.rms:12.4g}{s.largest:12.4g}{s.at_s:9.3f}{'' if np.isnan(s.share) else f'{s.share:.1%}':>12}"
            for s in moved
        )
        return "\n".join([*lines, head, *rows])

    def _none_differs(self) -> str:
        if not self.signals:
            return "nothing was compared: in no row of a common time do both logs have numbers of a signal"
        if not self.same:
            return "what was compared is the same to the last bit"
        return "every signal is the same to the last bit"

    def as_dict(self) -> dict[str, Any]:
        return {
            "runs": list(self.runs),
            "overlap_s": self.overlap_s,
            "changed": [{"about": each.about, "key": each.key, "a": each.a, "b": each.b} for each in self.changed],
            "vibration_mps2": {move: list(pair) for move, pair in self.vibration.items()},
            "signals": [
                {"name": s.name, "unit": s.unit, "rms": s.rms, "largest": s.largest, "at_s": s.at_s,
                 "share": None if np.isnan(s.share) else s.share} for s in self.signals
            ],
            "not_compared": asdict(self.not_compared),
        }  # fmt: skip

    def panels(self) -> list[Panel]:
        """A over B of the signals that differ most for what they are."""
        ranked = sorted((each for each in self.signals if each.largest > 0.0), key=lambda each: -np.nan_to_num(each.share))
        return [
            Panel(label(each.name), each.unit, (Line("A", a.t_s, a.values), Line("B", b.t_s, b.values, dashed=True)))
            for each in ranked[:PANELS]
            for a, b in (self.pairs[each.name],)
        ]


def difference(a: Log, b: Log, runs: tuple[int, int] | None = None, si: bool = False) -> LogDifference:
    """Of one run each (default: the first), or from the first cycle on where a log has none. Values in the units of A's rig file.

    LogError for a run that a log does not have.
    """
    chosen = runs or (_first_run(a), _first_run(b))
    common = common_time(a, b, chosen)
    pairs, left = aligned_signals(a, b, common, si)
    changed = (*_facts(a, b), *_rig(a, b), *_requests(a, b, chosen), *_ends(a, b, chosen))
    signals = tuple(_compared(*pair) for pair in pairs.values())
    return LogDifference(chosen, common.length_s, changed, signals, left, _vibration(a, b, chosen), pairs)


def _first_run(log: Log) -> int:
    return next((run.number for run in run_facts(log)), 0)


def _compared(a: ChosenSignal, b: ChosenSignal) -> SignalDifference:
    change = b.values - a.values
    rms, moves = float(np.sqrt(np.mean(change**2))), float(np.std(a.values))
    at = int(np.argmax(np.abs(change)))
    return SignalDifference(a.name, a.unit, rms, float(np.abs(change[at])), float(a.t_s[at]), rms / moves if moves > 0.0 else float("nan"))


def _facts(a: Log, b: Log) -> Iterator[ChangedValue]:
    left, right = (log.metadata.get("recording", {}) for log in (a, b))
    for key in FACTS:
        if left.get(key) != right.get(key):
            yield ChangedValue("log", key, left.get(key), right.get(key))


def _rig(a: Log, b: Log) -> Iterator[ChangedValue]:
    yield from _changed("rig", *(_flat_yaml(log.attachments.get("rig.yaml", b"")) for log in (a, b)))


def _requests(a: Log, b: Log, runs: tuple[int, int]) -> Iterator[ChangedValue]:
    left, right = (json.loads(log.attachments.get(f"run-{run}.json", b"{}")) for log, run in ((a, runs[0]), (b, runs[1])))
    yield from _changed("filter", *(_flat(each.pop("shaper", {})) for each in (left, right)))
    yield from _changed("maneuver", *(_flat(each.pop("maneuver", {})) for each in (left, right)))
    for each in (left, right):
        each.pop("run", None)
    yield from _changed("run", _flat(left), _flat(right))


def _ends(a: Log, b: Log, runs: tuple[int, int]) -> Iterator[ChangedValue]:
    """How long each lasted and how it ended: beyond the shorter one nothing is compared."""
    yield from _changed("run", *(_end(log, run) for log, run in zip((a, b), runs, strict=True)))


def _end(log: Log, run: int) -> dict[str, Any]:
    if run == 0:
        return {"duration_s": round(log.duration_s, 6)}
    found = run_of(log, run)
    return {"duration_s": round(found.duration_s, 6), "verdict": "valid" if found.valid else f"not valid: {found.reason}"}


def _changed(about: str, left: dict[str, Any], right: dict[str, Any]) -> Iterator[ChangedValue]:
    for key in dict.fromkeys([*left, *right]):
        if left.get(key) != right.get(key):
            yield ChangedValue(about, key, left.get(key), right.get(key))


def _flat_yaml(data: bytes) -> dict[str, Any]:
    try:
        return _flat(parse(data.decode(), "rig.yaml").plain) if data else {}
    except LongreachError:
        return {}


def _flat(value: Any, path: str = "") -> dict[str, Any]:
    """Nested mappings and lists as dotted keys; lists of plain values stay one value."""
    if isinstance(value, dict):
        return {key: each for part, inner in value.items() for key, each in _flat(inner, f"{path}.{part}" if path else str(part)).items()}
    if isinstance(value, list) and any(isinstance(inner, (dict, list)) for inner in value):
        return {key: each for index, inner in enumerate(value) for key, each in _flat(inner, f"{path}[{index}]").items()}
    return {path: value}


def _vibration(a: Log, b: Log, runs: tuple[int, int]) -> dict[str, tuple[float | None, float | None]]:
    left, right = (_by_move(log, run) for log, run in zip((a, b), runs, strict=True))
    return {move: (left.get(move), right.get(move)) for move in dict.fromkeys([*left, *right])}


def _by_move(log: Log, run: int) -> dict[str, float]:
    try:
        holds: list[HoldVibration] = hold_vibration(log)
    except LongreachError:
        return {}
    return {hold.move: hold.amplitude_mps2 for hold in holds if hold.run == run}


def _number(value: float | None) -> str:
    return "(none)" if value is None else f"{value:.3f}"
