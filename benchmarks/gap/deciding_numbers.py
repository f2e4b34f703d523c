"""`python -m benchmarks.gap.deciding_numbers`: what moves in the search by evidence when each of its deciding numbers is doubled or halved.

Cases are short logs of a simulated axis (tests.support.gap): nothing missing, friction of another form, a missing friction, a friction of
three times its stated size. A row a number: P(right) of every case with it halved and doubled, beside the row with all as they are.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from config.loading.load import LoadedRig, rig_from_text
from gap.data.experiments import experiments_of
from gap.data.measured import Measured, load
from gap.evidence import deciding_numbers, opening, stages
from gap.evidence.search_state import EvidenceSearch
from gap.fitting.nuisance import nuisances
from gap.settings import Settings
from tests.support.gap import axis_logs
from tests.support.gap.maxwell_axis import maxwell_axis

# What the words alone use moves no probability.
NUMBERS = (
    "MEMORY_S",
    "SPREAD",
    "HONEST",
    "LEAST_DISCREPANCY",
    "OTHER_FORM",
    "COUNT",
    "EXPECTED",
    "RANGE_SDS",
    "CHANGED_TIMES",
    "NEGLIGIBLE",
)
SECONDS = 8.0


def main() -> int:
    """Prints a Markdown table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gap.deciding_numbers", description=__doc__)
    parser.add_argument("--seed", type=int, default=950_301)
    parser.add_argument("--numbers", nargs="+", default=NUMBERS, choices=NUMBERS, metavar="NAME")
    arguments = parser.parse_args()
    print("| number | times | nothing missing | other friction | friction missing | friction three times |\n|---|---|---|---|---|---|")
    print(_row("all as they are", "1", right(arguments.seed)), flush=True)
    for name in arguments.numbers:
        for times in (0.5, 2.0):
            with scaled(name, times):
                print(_row(f"`{name}`", f"{times:g}", right(arguments.seed)), flush=True)
    return 0


def _row(name: str, times: str, found: Mapping[str, float]) -> str:
    return f"| {name} | {times} | " + " | ".join(f"{p:.3f}" for p in found.values()) + " |"


@contextmanager
def scaled(name: str, times: float) -> Iterator[None]:
    """One deciding number other than it is, wherever it is used."""
    own = getattr(deciding_numbers, name)
    users = [module for place, module in list(sys.modules.items()) if place.startswith("gap.evidence.") and hasattr(module, name)]
    try:
        for module in users:
            setattr(module, name, times * own)
        yield
    finally:
        for module in users:
            setattr(module, name, own)


def right(seed: int) -> dict[str, float]:
    """Probability of the right answer, case by case."""
    text, lacking = axis_logs.axis_text(), axis_logs.axis_text("coulomb_friction")
    plain, rough = rig_from_text(text), rig_from_text(text.replace("friction: 20.39 N", "friction: 61.17 N"))
    cases = {
        "nothing": (text, lambda s: axis_logs.simulated(plain, s, SECONDS), ""),
        "other friction": (text, lambda s: maxwell_axis(s, SECONDS), ""),
        "missing": (lacking, lambda s: axis_logs.simulated(plain, s, SECONDS), "coulomb_friction at axis"),
        "three times": (text, lambda s: axis_logs.simulated(rough, s, SECONDS), "coulomb_friction at axis changed (friction)"),
    }
    found = {}
    for name, (file, made, label) in cases.items():
        with tempfile.TemporaryDirectory() as folder:
            logs = [axis_logs.write(Path(folder) / f"{k}.csv", made(seed + k)) for k in (0, 1)]
            found[name] = _probability(LoadedRig(rig_from_text(file), file, "axis.yaml"), logs, label)
    return found


def _probability(loaded: LoadedRig, paths: list[Path], label: str) -> float:
    """Of a suspect; of none for an empty label."""
    logs = [load(path, loaded.rig) for path in paths]
    found = finished(loaded, logs[:1], logs[1:]).posterior
    return found.of(label) if label else found.none


def finished(loaded: LoadedRig, logs: Sequence[Measured], holdouts: Sequence[Measured]) -> EvidenceSearch:
    """All stages of the search on `logs`. Of `holdouts` only the noise is looked at."""
    names, experiments, _ = experiments_of(loaded, logs, holdouts, Settings(workers=1))
    search = opening.opening(loaded.rig, nuisances(loaded, frozenset(names)), experiments, names)
    for stage in stages.STAGES:
        search = stage(search, lambda line: None)
    return search


if __name__ == "__main__":
    raise SystemExit(main())
