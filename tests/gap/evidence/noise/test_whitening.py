"""What is kept of the rows that stay the same gives what a filter of all rows gives, channel by channel, also after it was let go."""

from __future__ import annotations

import numpy as np
import pytest

from gap.evidence.noise import whitening
from gap.evidence.noise.discrepancy_search import fitted_discrepancy
from gap.evidence.noise.noise_model import Discrepancy, less_states_with
from gap.evidence.noise.ornstein_uhlenbeck import at_rung, rung
from gap.evidence.noise.whitening import Whitening
from tests.gap.evidence.noise.test_noise_model import log


def parts(made: Whitening, left: np.ndarray, sizes: np.ndarray, times: np.ndarray) -> list[whitening.Part]:
    return [made.part(c, np.ascontiguousarray(left[..., c].T), sizes[:, c], int(times[c])) for c in range(2)]


@pytest.mark.parametrize("kept_bytes", [200_000_000, 0])
def test_channels_by_themselves_make_up_the_whole(monkeypatch: pytest.MonkeyPatch, kept_bytes: int) -> None:
    monkeypatch.setattr(whitening, "_KEPT_BYTES", kept_bytes)
    draw = np.random.default_rng(23)
    e, unknowns = log(draw)
    made, fresh = Whitening(e, unknowns), Whitening(e, unknowns)
    for _ in range(4):  # other residuals beside the same rows, and other sizes
        left = np.where(np.isfinite(e.measured), draw.normal(size=e.measured.shape), 0.0)
        sizes, times = draw.integers(-8, 12, size=(5, 2)), rung(np.array([0.03, 0.006])) + draw.integers(-2, 3, size=2)
        of_channels = parts(made, left, sizes, times)
        grams, log_det = fresh.grams([left[None]], at_rung(sizes), at_rung(times))
        np.testing.assert_allclose(sum(p.whole for p in of_channels), grams, rtol=1e-10, atol=1e-10)
        np.testing.assert_allclose(np.stack([p.log_det for p in of_channels], axis=1), log_det, atol=1e-10)


def test_a_part_added_on_the_way_is_a_part_added_before() -> None:
    draw = np.random.default_rng(29)
    e, unknowns = log(draw)
    left = np.where(np.isfinite(e.measured), draw.normal(size=e.measured.shape), 0.0)
    one, other = parts(Whitening(e, unknowns), left, draw.integers(-8, 12, size=(5, 2)), rung(np.array([0.03, 0.006])))
    on_the_way, before = less_states_with(one.whole, other, 3), less_states_with(one.whole + other.whole, None, 3)
    np.testing.assert_allclose(on_the_way.inner, before.inner, rtol=1e-12)
    assert on_the_way.log_det == pytest.approx(before.log_det, rel=1e-12)


@pytest.mark.parametrize("kept_bytes", [200_000_000, 0])
def test_the_number_of_threads_changes_no_bit_of_what_is_found(monkeypatch: pytest.MonkeyPatch, kept_bytes: int) -> None:
    """Two logs of two channels each; several threads look for the discrepancy of one channel side by side."""
    monkeypatch.setattr(whitening, "_KEPT_BYTES", kept_bytes)
    draw = np.random.default_rng(31)
    pairs = [log(draw) for _ in range(2)]
    left = [np.where(np.isfinite(e.measured), 3.0 * draw.normal(size=e.measured.shape), 0.0) for e, _ in pairs]
    start = Discrepancy(np.array([1.0, 5.0]), np.array([0.03, 0.006]), 0.3)

    def found(threads: int) -> list[np.ndarray]:
        for e, _ in pairs:
            e.workers = threads
        logs = [Whitening(e, unknowns) for e, unknowns in pairs]
        at = fitted_discrepancy(logs, left, np.array([5.0, 5.0]), start)
        return [at.sd, at.time_s, np.array(at.share), *at.times]

    alone = found(1)
    for threads in (2, 5):
        assert all(np.array_equal(one, other) for one, other in zip(alone, found(threads), strict=True))
