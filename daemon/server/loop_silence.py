"""A loop that stands still: a driver that blocks, a process that was stopped. What it last said is not so any more, and it obeys nobody."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from recording.format.event import Level

SILENT_S = 0.5  # without a cycle
STANDS_STILL = "loop_silent"  # name of the event
MOVES_AGAIN = "loop_moves_again"
ADVICE = (
    "Press the hardware e-stop: no command reaches the loop. Its devices go safe by their own time-outs. "
    "A driver that blocks, or a stopped process, holds it up: `longreach events`, then start longreachd again."
)


class SilenceTeller:
    """`add_event`: name, text, level."""

    def __init__(self, add_event: Callable[[str, str, Level], None]) -> None:
        self._add_event, self._silent_s = add_event, 0.0

    def tell(self, silent_s: float) -> None:
        """Once when the loop has come to stand still, and once when it moves again. `silent_s`: 0 while it moves."""
        if silent_s and not self._silent_s:
            self._add_event(STANDS_STILL, f"{sentence(silent_s)}. {ADVICE}", Level.ERROR)
        elif self._silent_s and not silent_s:
            self._add_event(MOVES_AGAIN, f"the loop moves again after {self._silent_s:.1f} s", Level.WARNING)
        self._silent_s = silent_s


def sentence(silent_s: float) -> str:
    return f"the loop has stood still for {silent_s:.1f} s (limit {SILENT_S:g} s)"


def silence_row(silent_s: float) -> dict[str, Any]:
    """As the row of a check that fails."""
    return {
        "name": "loop stands still", "ok": False, "value": round(silent_s, 1), "limit": f"≤ {SILENT_S:g}", "unit": "s",
        "source": "supervisor", "age_s": None, "severity": "error", "reaction": "", "next_step": ADVICE, "page": "",
    }  # fmt: skip
