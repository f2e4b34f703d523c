"""Which checks a rig has, from their declarations, and what computes the facts that only checks need."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module

from config.schema.rig import Rig
from daemon.checks import declared
from daemon.checks.checks import Check
from daemon.checks.declaration import FactWatch, Family, Purpose, Subject
from daemon.cycle.facts import Facts
from recording.format.layout import CycleLayout


def families() -> list[Family]:
    """Every family of every file in `declared`, causes before their consequences."""
    modules = [import_module(f"{declared.__name__}.{found.name}") for found in pkgutil.iter_modules(declared.__path__)]
    return sorted((family for module in modules for family in module.FAMILIES), key=lambda family: family.stage)


def rig_facts(rig: Rig) -> Facts:
    """The facts of a rig: those that every loop has, and those that are declared with its checks."""
    found = [(fact, subject) for family, subject in _subjects(rig) for fact in family.facts]
    return Facts(rig, CycleLayout.of_rig(rig), {fact.name.format_map(subject): fact.blank for fact, subject in found})


def interlocks(rig: Rig, facts: Facts) -> tuple[Check, ...]:
    """Every check that must pass to arm and while armed."""
    return _checks(rig, facts, Purpose.ARMED)


def proof_checks(rig: Rig, facts: Facts) -> tuple[Check, ...]:
    """What must hold before and during the proof of the safe state: valves open, so no pressure may be there; and it must be logged."""
    return _checks(rig, facts, Purpose.PROOF)


def rest_checks(rig: Rig, facts: Facts) -> tuple[Check, ...]:
    """What a run waits for that is to start from rest."""
    return _checks(rig, facts, Purpose.REST)


def not_passed(checks: Sequence[Check], values: Sequence[float]) -> Iterator[str]:
    """A sentence for each check that fails."""
    return (check.sentence(values) for check in checks if not check.passes(values))


def watches(rig: Rig, facts: Facts, wanted: Callable[[Family], bool]) -> list[FactWatch]:
    """What computes the declared facts of the wanted families, where the rig has a subject of them."""
    return [family.watch(rig, facts) for family in families() if family.watch and wanted(family) and list(family.subjects(rig))]


def facts_from_log(rig: Rig) -> Iterator[str]:
    """Names of the declared facts that the columns of a log give, by the same arithmetic as in the loop."""
    return (fact.name.format_map(subject) for family, subject in _subjects(rig) if family.from_log for fact in family.facts)


def _checks(rig: Rig, facts: Facts, purpose: Purpose) -> tuple[Check, ...]:
    made = (
        declaration.check(rig, subject, facts)
        for family, subject in _subjects(rig)
        for declaration in family.checks
        if purpose in declaration.purposes
    )
    return tuple(check for check in made if check is not None)


def _subjects(rig: Rig) -> Iterator[tuple[Family, Subject]]:
    return ((family, subject) for family in families() for subject in family.subjects(rig))
