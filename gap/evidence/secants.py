"""What a number of the rig file changes on its way to another value: one straight line from where a set has it.

Sensitivities tell of a number as far as it is known where it stands. They hardly show what a valve's hysteresis of seven times the stated
width changes, or a stiction of three times the stated force; a missing effect is tried in several sizes for the same reason.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gap.data.measured import Array
from gap.evidence.noise.unknowns import in_noise
from gap.evidence.score.changed import Changed
from gap.evidence.score.coordinates import phi_of
from gap.evidence.score.hypothesis import Hypothesis, Seen
from gap.fitting.model import Model
from gap.fitting.simulate import on_logs

CLOSE = 1.3  # ratio of two sizes up to which a straight line to the one is as good for the other


@dataclass(frozen=True, slots=True)
class Secant:
    """`columns`: d readings / dφ of the number between the base's value and `value`, with its wide prior; windows × samples × channels, one
    array a log."""

    suspect: Changed
    value: float
    columns: tuple[Array, ...]


def secants_to(seen: Seen, base: Hypothesis, values: Mapping[str, float], suspects: Sequence[Changed]) -> list[Secant]:
    """Of every suspect whose value, by label, is within its range and not the one that the base has."""
    tried = [(s, values[s.label]) for s in suspects if s.free.low <= values[s.label] <= s.free.high]
    tried = [(s, value) for s, value in tried if not _close(value, s.value_in(base.model))]
    wide = [(s.with_wide_prior(base.model), s, value) for s, value in tried]
    there = [s.with_value(model, value) for model, s, value in wide]
    moved = on_logs(seen.experiments, [model.vector() for model in there])
    found = []
    for k, (model, suspect, value) in enumerate(wide):
        number = suspect.number_in(model)
        step = float((phi_of(there[k]) - phi_of(model))[number])
        changes = zip(seen.experiments, moved, base.at.readings, strict=True)
        found.append(Secant(suspect, value, tuple(in_noise(e, m[k] - r) / step for e, m, r in changes)))
    return found


def secant_where_led(seen: Seen, base: Hypothesis, suspect: Changed, taken: Secant | None, there: Model) -> Secant | None:
    """To where lines have led; None where they end there, or have not gone far without."""
    led = suspect.value_in(there)
    if taken is not None and _close(led, taken.value):
        return None
    return next(iter(secants_to(seen, base, {suspect.label: led}, [suspect])), None)


def _close(one: float, other: float) -> bool:
    return one == other or (one * other > 0.0 and 1.0 / CLOSE < one / other < CLOSE)
