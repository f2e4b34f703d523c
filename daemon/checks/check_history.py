"""When each check failed and passed again within a span of a log: the same objects as in the loop, asked in every cycle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from daemon.checks.checks import Check, Reaction
from daemon.checks.interlocks import interlocks, rig_facts
from daemon.checks.past_checks import MEMORY_S, known_facts, walked
from recording.files.reader import Log, open_rig

ACTING = (Reaction.FAULT, Reaction.STOP_THEN_FAULT, Reaction.STOP)  # what acts on an armed rig; the others only refuse arming


@dataclass(frozen=True, slots=True)
class Change:
    """A check that failed (`ok` False) or passed again in the cycle of row `row`; `text` as the daemon says it."""

    row: int
    t_s: float
    check: Check
    ok: bool
    text: str


@dataclass(frozen=True, slots=True)
class CheckHistory:
    """`changes` in their order; `failing`: those that do not pass at the end, with the row since when. `numbers`: of each check that ever
    failed, its number in every row of the span."""

    start: int
    changes: list[Change]
    failing: dict[str, Change]
    numbers: dict[str, npt.NDArray[np.float64]]


def check_history(log: Log, start: int, end: int) -> CheckHistory:
    """Of the rows `start` to `end`, both included. LogError for a log without a rig file. Costs some 0.1 ms of processor time a row."""
    rig = open_rig(log)
    facts = rig_facts(rig)
    known = known_facts(log, rig, facts)
    asked = [check for check in interlocks(rig, facts) if check.reaction in ACTING and check.index in known]
    failing: dict[str, Change] = {}
    changes: list[Change] = []
    table: list[tuple[float, ...]] = []
    warm = max(0, start - round(MEMORY_S * rig.loop.rate_Hz))
    at_t = facts.index("t_s")
    for row, values in enumerate(walked(log, rig, facts, warm, end), start=warm):
        if row < start:
            continue
        table.append(tuple(values[check.index] for check in asked))
        for check in asked:
            if check.passes(values) is not (check.name in failing):
                continue
            change = Change(row, values[at_t], check, check.name in failing, check.sentence(values))
            changes.append(change)
            if change.ok:
                del failing[check.name]
            else:
                failing[check.name] = change
    return CheckHistory(start, changes, failing, _numbers_of_failed(table, asked, changes))


def _numbers_of_failed(table: list[tuple[float, ...]], asked: list[Check], changes: list[Change]) -> dict[str, npt.NDArray[np.float64]]:
    """Check → the number it read in every row, of the checks that ever failed."""
    columns = np.array(table, dtype=np.float64).reshape(len(table), len(asked))
    failed = {change.check.name for change in changes}
    return {check.name: columns[:, k] for k, check in enumerate(asked) if check.name in failed}
