"""A loop that stands still: a driver that blocks, a process that was stopped. What it last said is not so any more, and it obeys nobody."""

from __future__ import annotations

from typing import Any

SILENT_S = 0.5  # without a cycle
STANDS_STILL = "loop_silent"  # name of the event
MOVES_AGAIN = "loop_moves_again"
ADVICE = (
    "Press the hardware e-stop: no command reaches the loop. Its devices go safe by their own time-outs. "
    "A driver that blocks, or a stopped process, holds it up: `longreach events`, then start longreachd again."
)


def sentence(silent_s: float) -> str:
    return f"the loop has stood still for {silent_s:.1f} s (limit {SILENT_S:g} s)"


def silence_row(silent_s: float) -> dict[str, Any]:
    """As the row of a check that fails."""
    return {
        "name": "loop stands still", "ok": False, "value": round(silent_s, 1), "limit": f"≤ {SILENT_S:g}", "unit": "s",
        "source": "supervisor", "age_s": None, "severity": "error", "reaction": "", "next_step": ADVICE, "page": "",
    }  # fmt: skip
