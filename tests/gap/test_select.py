"""How many windows must agree before a candidate is named."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from gap.select import _clear


@pytest.mark.parametrize(
    ("t", "gain", "clear"),
    [(3.4, 0.5, False), (3.9, 0.5, True), (2.5, 0.97, True), (1.9, 0.97, False), (2.5, 0.89, False)],
    ids=["few windows", "enough windows", "few, but all of the gap", "hardly any", "few, and not all of it"],
)
def test_a_candidate_that_closes_the_gap_needs_fewer_windows(t: float, gain: float, clear: bool) -> None:
    trial: Any = SimpleNamespace(t=t, gain=gain)
    assert _clear(trial, 3.8) is clear
