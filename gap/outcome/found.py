"""The outcome of a search: everything the report, the findings file and the improved rig file need."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from config.loading.load import LoadedRig
from gap.data.data_check import DataProblem
from gap.data.measured import Array
from gap.fitting.evaluation import Evaluation
from gap.outcome.localise import Disagreement
from gap.outcome.search_state import SearchState
from gap.outcome.verdict import Verdict


@dataclass(frozen=True, slots=True)
class Found:
    """A finished search. Costs in noise floors, on the hold-out. `final`: with what the fit logs gave; `with_all_logs`: with constants
    fitted to all logs, where those are written. `content` is findings.json as a dictionary."""

    rig: LoadedRig
    channels: list[str]
    state: SearchState
    nominal: tuple[Evaluation, ...]
    final: tuple[Evaluation, ...]
    half_width: Array
    verdict: Verdict
    places: list[Disagreement]
    problems: list[DataProblem]
    improved_text: str
    content: dict[str, Any]
    with_all_logs: tuple[Evaluation, ...] | None = None
