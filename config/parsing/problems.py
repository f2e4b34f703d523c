"""Problems found in a file: each with its place, all reported at once and in the order of the file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from config.errors import ConfigError, Mend, Refusal


@dataclass(frozen=True, order=True, slots=True)
class Problem:
    """One thing wrong at one place; line and column count from 1.

    `follows`: the problem only follows from another one, as a unit does from the misspelt name of a joint; it is told only
    when no other problem is known.
    """

    line: int
    column: int
    refusal: Refusal = field(compare=False)
    follows: bool = field(default=False, compare=False)


def problem_at(
    name: str,
    line: int,
    column: int,
    what: str,
    *,
    value: str = "",
    limit: str = "",
    unit: str = "",
    next_step: str = "",
    mend: Mend | None = None,
) -> Problem:
    """A problem whose `where` is name:line:column."""
    return Problem(line, column, Refusal(what, value, limit, unit, f"{name}:{line}:{column}", next_step, mend or {}))


def config_error(name: str, problems: Sequence[Problem]) -> ConfigError:
    """One ConfigError that says them all."""
    causes = [problem for problem in problems if not problem.follows] or problems
    refusals = tuple(problem.refusal for problem in sorted(causes))
    if len(refusals) == 1:
        return _single(refusals[0])
    lines = "".join(f"\n  {refusal.text()}" for refusal in refusals)
    return ConfigError(f"{len(refusals)} problems in {name}:{lines}", problems=refusals)


def _single(refusal: Refusal) -> ConfigError:
    return ConfigError(
        refusal.what,
        value=refusal.value,
        limit=refusal.limit,
        unit=refusal.unit,
        where=refusal.where,
        next_step=refusal.next_step,
        mend=refusal.mend,
    )
