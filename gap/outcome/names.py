"""What a search names, and what the logs do not tell from it."""

from __future__ import annotations

from dataclasses import dataclass

from config.schema.effect_library import EFFECTS
from gap.data.measured import Array
from gap.evidence.judgement.votes import Votes
from gap.evidence.score.changed import Changed
from gap.evidence.score.hypothesis import Suspect
from gap.fitting.evaluation import Evaluation
from gap.fitting.fit import Fit
from gap.fitting.model import Model


@dataclass(frozen=True, slots=True)
class Fitted:
    """A model and the 95 % half width of each of its free numbers, in its unit."""

    model: Model
    half_width: Array


@dataclass(frozen=True, slots=True)
class Explanation:
    """A fitted model with a suspect in it, and what that gains on the hold-out over the model without it.

    `holdout`, `without`: the hold-out with that model and without the suspect. `gain`: share of the excess over the floor.
    """

    suspect: Suspect
    fit: Fit
    holdout: tuple[Evaluation, ...]
    without: tuple[Evaluation, ...]
    gain: float
    t: float


@dataclass(frozen=True, slots=True)
class LookAlike:
    """What the logs do not tell from a name. `share`: of what the set has with any of them in this place."""

    explanation: Explanation
    share: float
    votes: Votes | None


@dataclass(frozen=True, slots=True)
class Named:
    """An effect, or the change of a number, that is named."""

    explanation: Explanation
    probability: float
    confirmed: bool
    votes: Votes | None
    look_alikes: tuple[LookAlike, ...]

    @property
    def suspect(self) -> Suspect:
        return self.explanation.suspect

    @property
    def equation(self) -> str:
        """The balance that it enters; empty for a constant."""
        effect = EFFECTS.get(self.suspect.effect)
        return effect.search.equation if effect and effect.search else ""


def numbers_of(suspect: Suspect, model: Model) -> list[int]:
    """The free numbers of a model that are the suspect's."""
    if isinstance(suspect, Changed):
        return [k for k, free in enumerate(model.free) if free.key == suspect.free.key]
    return model.of_effect(model.entry_added(suspect.effect, suspect.where))
