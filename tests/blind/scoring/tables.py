"""Scores counted: every number of the page with its Wilson interval."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from statistics import median

from tests.blind.scoring.score import QUIET, Score, right
from tests.blind.scoring.wilson import half_power, wilson
from tests.blind.truth.friction import BRISTLE, RIGID, SLIP

FORMS = {SLIP: "Maxwell-slip", RIGID: "without presliding", BRISTLE: "LuGre, as the finder's"}


@dataclass(frozen=True, slots=True)
class Share:
    """So many of so many."""

    hits: int
    trials: int

    def text(self) -> str:
        """`12 of 15, 80 % (55 to 93)`; a dash where nothing was run."""
        if not self.trials:
            return "–"
        low, high = wilson(self.hits, self.trials)
        return f"{self.hits} of {self.trials}, {self.hits / self.trials:.0%} ({100 * low:.0f} to {100 * high:.0f})"


def share(scores: Iterable[Score], hit: Callable[[Score], bool]) -> Share:
    rows = list(scores)
    return Share(sum(hit(s) for s in rows), len(rows))


def of_group(scores: Sequence[Score], group: str) -> list[Score]:
    return [s for s in scores if s.case.group == group]


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [f"| {' | '.join(head)} |", f"|{'---|' * len(head)}"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)]) + "\n"


def by_effect(scores: Sequence[Score]) -> list[list[str]]:
    """One row an effect: named at 1×, 3×, 10×; parameter error; what else came first."""
    rows = []
    single = of_group(scores, "single")
    for effect, where in sorted({s.case.truth[0] for s in single}):
        own = [s for s in single if s.case.truth[0] == (effect, where)]
        cells = []
        for multiple in (1.0, 3.0, 10.0):
            some = [s for s in own if s.case.multiple == multiple]
            cells.append(f"{sum(s.in_set for s in some)}/{len(some)}" if some else "–")
        errors = [s.parameter_error for s in own if s.parameter_error is not None and s.case.multiple >= 3]
        half = half_power([s.case.multiple for s in own], [s.in_set for s in own])
        others = Counter(f"{e} at {w}" for s in own for e, w in s.wrong[:1])
        rows.append(
            [f"`{effect}` {where}", *cells, f"{half:.2g}×" if half else "–", f"{median(errors):.0%}" if errors else "–",
             ", ".join(f"{name} ({count})" for name, count in others.most_common(2))]
        )  # fmt: skip
    return rows


def by_form(scores: Sequence[Score]) -> list[list[str]]:
    """The same by the hidden machine's friction law."""
    rows = []
    for form, name in FORMS.items():
        own = [s for s in scores if s.case.setting.friction_form == form]
        large = [s for s in own if s.case.group == "single" and s.case.multiple >= 3]
        null = of_group(own, "null")
        rows.append([name, share(large, lambda s: s.in_set).text(), share(large, lambda s: s.in_set and s.closed).text(),
                     share(null, lambda s: s.verdict in QUIET).text(),
                     share(null, lambda s: bool(s.wrong)).text()])  # fmt: skip
    return rows


def by_sensors(scores: Sequence[Score]) -> list[list[str]]:
    """With and without chamber pressures."""
    large = [s for s in of_group(scores, "single") if s.case.multiple >= 3]
    return [
        [text, share([s for s in large if s.case.setting.chambers is chambers], lambda s: s.in_set).text()]
        for text, chambers in (("with chamber pressures", True), ("without", False))
    ]


def failures(scores: Sequence[Score]) -> list[list[str]]:
    """Every case that did not come out right, 1× ones left out: they may go either way."""
    rows = []
    for s in scores:
        if right(s) or s.case.multiple == 1:
            continue
        hidden = ", ".join(f"{h.effect} at {h.where} = {h.value:.3g}" for h in s.case.setting.hidden) or "nothing"
        named = ", ".join(f"{e} at {w}" for e, w in s.wrong) or "–"
        rows.append([s.case.name, s.case.group, f"{hidden} ({s.case.multiple:g}×)", s.verdict, named])
    return rows
