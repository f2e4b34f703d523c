"""One row of the acceptance table: a claim of the paper, what the running code gives, what it must give."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from config.schema.rig import Rig


@dataclass(frozen=True, slots=True)
class ClaimRow:
    """`measured` and `target` are text with units; `ok` was decided from the numbers. `note` says what else must be known."""

    row: int
    claim: str
    measured: str
    target: str
    tolerance: str
    ok: bool
    note: str = ""


PAYLOAD_KG = 45 * 0.45359237  # of the paper's tests
SWEEP_HZ = (0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0)

RowMaker = Callable[[Rig], ClaimRow]


def near(measured: Sequence[float], target: Sequence[float], *, relative: float = 0.0, absolute: float = 0.0) -> bool:
    """Every number within relative · |target| + absolute."""
    return all(abs(a - b) <= relative * abs(b) + absolute for a, b in zip(measured, target, strict=True))


def figures(values: Sequence[float], form: str = ".3g") -> str:
    """Numbers with slashes in between."""
    return " / ".join(format(value, form) for value in values)
