"""The picture of an effect beside the constant that imitates it: what is drawn is what the machine has."""

from __future__ import annotations

import pytest

from benchmarks.gap.imitation import STATED, drawn, weighed


@pytest.mark.slow
def test_the_constant_stays_true_beside_the_name_and_leaves_without_it() -> None:
    row = weighed(0.5)
    assert row.gain > row.needed
    assert row.probability > 0.99
    assert row.beside == pytest.approx(STATED, rel=2e-3)
    assert row.alone > 1.02 * STATED
    assert len(drawn([row, row]).axes) == 2
