"""A fit begun before it was asked for is used as long as it is the one that would be made, and forgotten else."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from gap.evidence import ahead
from gap.evidence.ahead import Ahead, fitted


class Search:
    """What a fit of a waiting set looks at: the logs, the base it starts from, and what the best set weighs."""

    def __init__(self, seen: object, base: object, best_mass: float) -> None:
        self.seen, self._base, self.best, self._mass = seen, base, object(), best_mass

    def fit_of(self, labels: frozenset[str]) -> object:
        return self._base

    def log_mass(self, hypothesis: object) -> float:
        return self._mass


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the waiting sets in the order in which they were fitted."""
    names: list[str] = []

    def refined(search: Search, waiting: Any) -> str:
        names.append(waiting.name)
        return f"fit of {waiting.name}"

    monkeypatch.setattr(ahead, "refined", refined)
    return names


def waiting(name: str) -> Any:
    return SimpleNamespace(name=name, base=SimpleNamespace(labels=frozenset[str]()))


def test_two_are_fitted_at_once_and_the_second_is_there_when_it_is_asked(made: list[str]) -> None:
    seen, base, first, second = SimpleNamespace(threads=2), object(), waiting("first"), waiting("second")
    search: Any = Search(seen, base, -5.0)
    done, known = fitted(search, first, second, None)
    assert (done, sorted(made)) == ("fit of first", ["first", "second"])
    later: Any = Search(seen, base, -5.0)  # another search, in which nothing that the fit looks at has changed
    done, known = fitted(later, second, waiting("third"), known)
    assert (done, known, sorted(made)) == ("fit of second", None, ["first", "second"])


@pytest.mark.parametrize("changed", ["logs", "base", "best", "asked"])
def test_it_is_made_again_when_what_it_looks_at_has_changed(made: list[str], changed: str) -> None:
    seen, base, second = SimpleNamespace(threads=2), object(), waiting("second")
    before: Any = Search(seen, base, -5.0)
    after: Any = Search(
        SimpleNamespace(threads=2) if changed == "logs" else seen,
        object() if changed == "base" else base,
        -4.0 if changed == "best" else -5.0,
    )
    asked = waiting("third") if changed == "asked" else second
    done, known = fitted(after, asked, None, Ahead(before, second, "old"))  # type: ignore[arg-type]
    assert (done, known, made) == (f"fit of {asked.name}", None, [asked.name])


def test_one_thread_begins_nothing_before_it_is_asked(made: list[str]) -> None:
    search: Any = Search(SimpleNamespace(threads=1), object(), -5.0)
    assert fitted(search, waiting("first"), waiting("second"), None) == ("fit of first", None)
    assert made == ["first"]
