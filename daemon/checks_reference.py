"""Writes docs/reference/checks.md from the declarations of the checks and from the mode machine.

`python -m daemon.checks_reference` rewrites the page; a test keeps it equal to the code.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from daemon.checks.checks import Reaction
from daemon.checks.declaration import REFERENCE_PAGE, Declaration, for_all
from daemon.checks.interlocks import families
from daemon.modes.mode_machine import Conditions, OperatorAction, update
from servo_control.signals import Mode

CHECKOUT = Path(__file__).parents[1]
# What the mode machine hears of a check that fails: see daemon.modes.mode_keeper.
_FAILED = {
    Reaction.FAULT: Conditions(fault=True, checks_pass=False),
    Reaction.STOP_THEN_FAULT: Conditions(fault_at_rest=True, checks_pass=False),
    Reaction.STOP: Conditions(stop=True, checks_pass=False),
    Reaction.REFUSE: Conditions(checks_pass=False),
    Reaction.WARN: Conditions(),
}
_MODES = (Mode.ARMING, Mode.HOLDING, Mode.RUNNING, Mode.STOPPING)
_HEAD = """\
# Checks

Generated from the checks' declarations (`daemon/checks/declared`) by `python -m daemon.checks_reference`; do
not edit.

`longreach why --all` shows every check with value, limit, unit, source and age. The same checks run in every
cycle: one that fails has its reaction in that cycle. When several fail, the most severe reaction wins. Of one
reaction the first in the order of this page is named: causes before consequences. A missing number (NaN)
fails. A check exists for every signal, joint or device for which the rig file sets a limit. Names in capitals
stand for those of the rig file; SOURCE is the device and channel that measure.

## Reactions

What a check that fails, and goes on failing, leads to from each mode. [Safety](../method/safety.md) explains
the modes.

"""


def page() -> str:
    """The whole page."""
    parts = [_HEAD, *_reactions()]
    for family in families():
        parts.append(f"\n## {family.about}\n")
        parts += map(_entry, family.checks)
    return "".join(parts)


def _reactions() -> Iterator[str]:
    """A table, from the mode machine itself."""
    yield f"| reaction | `arm` while disarmed | {' | '.join(mode.name.lower() for mode in _MODES)} | `start` while holding |\n"
    yield f"|---{'|---' * (len(_MODES) + 2)}|\n"
    for reaction, failed in _FAILED.items():
        arm = "refused" if update(Mode.DISARMED, OperatorAction.ARM, failed) is Mode.DISARMED else "goes on"
        ways = (" → ".join(mode.name.lower() for mode in _following_modes(start, failed)) or "goes on" for start in _MODES)
        begins = update(Mode.HOLDING, OperatorAction.START, failed) is Mode.RUNNING
        yield f"| {reaction} | {arm} | {' | '.join(ways)} | {'goes on' if begins else 'refused'} |\n"


def _following_modes(mode: Mode, failed: Conditions) -> Iterator[Mode]:
    """The modes that follow `mode` while the check goes on failing; a controlled stop comes to rest."""
    while True:
        following = update(mode, OperatorAction.NONE, replace(failed, at_rest=mode is Mode.STOPPING))
        if following is mode:
            return
        yield following
        mode = following


def _entry(check: Declaration) -> str:
    rows = {
        "number": f"`{for_all(check.fact)}`: {check.meaning}",
        "unit": check.unit.replace("{unit}", "that of the signal" if "{signal}" in check.name else "rad or m"),
        "passes": for_all(check.limit_from),
        "measured by": for_all(check.source),
        "a failure refuses": "; ".join(purpose.value for purpose in check.purposes),
        "reaction": check.reaction_from if not isinstance(check.reaction, Reaction) else str(check.reaction),
        "what to do": for_all(check.advice),
    }
    return f"\n### {check.title}\n\n| | |\n|---|---|\n" + "".join(f"| {key} | {text} |\n" for key, text in rows.items() if text)


def main() -> None:
    (CHECKOUT / REFERENCE_PAGE).write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
