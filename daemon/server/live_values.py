"""What live views ask for many times a second: the newest cycle as plain numbers; and, once, what each of them is."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from math import inf
from typing import Any

from config.errors import DaemonError
from config.loading.stated_units import conversions, sentence_units, stated_units
from config.schema.rig import Rig
from daemon.checks.checks import Check
from daemon.cycle.facts import Facts
from daemon.server.status import read_signals
from recording.format.fields import Field, field_of_signal, signals_of
from recording.format.layout import CycleLayout

_BESIDE_ROW = {"estop_latched": "", "run.number": "", "run.countdown_s": "s", "run.elapsed_s": "s", "run.duration_s": "s"}


class LiveValues:
    """`signals`: [name, SI unit] of every number of a sample. What the rig does not measure, raw counts and ages are left out."""

    def __init__(self, rig: Rig, facts: Facts) -> None:
        following = {f"{name}.following_error": joint.position_unit for name, joint in rig.joints.items()}
        row = {field.name: field.unit for field in _shown_fields(rig)}
        self.signals = [[name, unit] for name, unit in (row | _BESIDE_ROW | following).items()]
        self._indices = [facts.index(name) for name, _ in self.signals]
        self._at_t = facts.index("t_s")

    def sample(self, values: Sequence[float], since_t_s: float) -> dict[str, Any]:
        """`rows`: one, or none when it is not later than `since_t_s`. `unix_s`: when it was asked for."""
        return {"unix_s": time.time(), "rows": [self.row(values)] if values[self._at_t] > since_t_s else []}

    def row(self, values: Sequence[float]) -> list[float]:
        """One cycle's facts as a row of a sample."""
        return [values[index] for index in self._indices]


def since_t_s(params: Mapping[str, Any]) -> float:
    """The parameter of `sample`; DaemonError for what is no number."""
    since = params.get("since_t_s", -inf)
    if isinstance(since, bool) or not isinstance(since, (int, float)):
        raise DaemonError("since_t_s must be a time of the loop", value=repr(since)[:80], unit="s")
    return since


def units_answer(rig: Rig, checks: Sequence[Check], rig_text: str) -> dict[str, Any]:
    """How the rig file states what is SI in the daemon: `units` of checks, signals and joints [unit, factor, offset], shown = factor × SI +
    offset; `sentences`: the same by joint or signal and SI unit, for the numbers in texts."""
    if not rig_text:
        return {"units": {}, "sentences": {}}
    si = {check.name: check.unit for check in checks}
    si |= {name: unit for name, (_, unit) in read_signals(rig).items()}
    si |= {name: joint.position_unit for name, joint in rig.joints.items()}
    return {"units": conversions(si, stated_units(rig_text)), "sentences": sentence_units(rig_text)}


def _shown_fields(rig: Rig) -> Iterator[Field]:
    every = {field_of_signal(signal) for signal in signals_of(tuple(rig.joints))}
    unfitted = every - {field_of_signal(signal) for signal in rig.signals}
    for field in CycleLayout.of_rig(rig).fields:
        if field.name not in unfitted and not field.name.endswith(("_raw", "_age_s")):
            yield field
