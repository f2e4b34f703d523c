"""Pictures of docs/results/blind.md: confusion matrix and power curves."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np

from tests.blind.scoring.score import Score
from tests.blind.scoring.tables import of_group
from tests.blind.scoring.wilson import wilson

matplotlib.use("Agg")
import matplotlib.pyplot as plt

NOTHING = "(nothing)"


def confusion(scores: Sequence[Score], path: Path) -> None:
    """Hidden effect against the first name, single effects at 3× and 10×."""
    large = [s for s in of_group(scores, "single") if s.case.multiple >= 3]
    counts = Counter((s.case.truth[0][0], _first(s)) for s in large)
    rows = sorted({hidden for hidden, _ in counts})
    columns = [*rows, *sorted({name for _, name in counts} - {*rows, NOTHING}), NOTHING]
    matrix = np.array([[counts[(r, c)] for c in columns] for r in rows], dtype=float)
    if not matrix.size:
        return
    figure, axes = plt.subplots(figsize=(0.28 * len(columns) + 2.6, 0.26 * len(rows) + 2.2))
    axes.imshow(matrix / np.maximum(matrix.sum(axis=1, keepdims=True), 1), cmap="Blues", vmin=0, vmax=1, aspect="auto")
    for (r, c), value in np.ndenumerate(matrix):
        if value:
            axes.text(c, r, f"{value:.0f}", ha="center", va="center", fontsize=6, color="black")
    axes.set_xticks(range(len(columns)), columns, rotation=90, fontsize=6)
    axes.set_yticks(range(len(rows)), rows, fontsize=6)
    axes.set_xlabel("first name (right when it or its set holds the hidden effect)", fontsize=7)
    axes.set_ylabel("hidden", fontsize=7)
    save(figure, path)


def _first(score: Score) -> str:
    """The hidden effect where it is in the first set, else the first wrong name."""
    if score.in_set:
        return score.case.truth[0][0]
    return score.wrong[0][0] if score.wrong else NOTHING


def power(scores: Sequence[Score], path: Path) -> None:
    """Share named over the size in smallest visible ones, with Wilson intervals: all effects together, and with and without chambers."""
    figure, axes = plt.subplots(figsize=(5, 3.2))
    single = of_group(scores, "single")
    sets = [("all", single, "black"), ("with chamber pressures", [s for s in single if s.case.setting.chambers], "tab:blue"),
            ("without", [s for s in single if not s.case.setting.chambers], "tab:orange")]  # fmt: skip
    for number, (label, own, colour) in enumerate(sets):
        sizes = sorted({s.case.multiple for s in own})
        for multiple in sizes:
            some = [s for s in own if s.case.multiple == multiple]
            hits = sum(s.in_set for s in some)
            low, high = wilson(hits, len(some))
            x = multiple * (1 + 0.06 * (number - 1))
            axes.plot([x, x], [low, high], color=colour, lw=1)
            axes.plot(x, hits / len(some), "o", color=colour, ms=4, label=label if multiple == sizes[0] else None)
    axes.set_xscale("log")
    axes.set_xticks([1, 3, 10], ["1×", "3×", "10×"])
    axes.axhline(0.95, color="grey", lw=0.5, ls="--")
    axes.set_ylim(0, 1.02)
    axes.set_xlabel("size of the hidden effect, in smallest visible ones")
    axes.set_ylabel("named (first or in its set)")
    if single:
        axes.legend(fontsize=7)
    save(figure, path)


def save(figure: plt.Figure, path: Path) -> None:
    """As a PNG that is the same for the same figure; its folder is made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.tight_layout()
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)
