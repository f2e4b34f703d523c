"""What one channel's other discrepancy makes of the sum of all channels, also of a channel that nothing integrated out reaches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gap.evidence.noise.channel_sums import ChannelSums
from gap.evidence.noise.noise_model import less_shared, weighed
from gap.evidence.noise.ornstein_uhlenbeck import rung
from gap.evidence.noise.rungs import Rungs
from gap.evidence.noise.unknowns import Unknowns
from gap.evidence.noise.whitening import Whitening
from tests.gap.evidence.noise.test_noise_model import log

LOGS = 2


def two_logs(draw: np.random.Generator, reached: list[bool]) -> list[Whitening]:
    """Of two channels each, of which what is integrated out changes these."""
    made = []
    for _ in range(LOGS):
        e, unknowns = log(draw)
        made.append(Whitening(e, Unknowns(unknowns.states * reached, unknowns.forms * reached)))
    return made


def any_discrepancy(draw: np.random.Generator) -> Rungs:
    times = tuple(draw.integers(-4, 5, size=(5, 2)) for _ in range(LOGS))
    return Rungs(draw.integers(-8, 12, size=2), rung(np.array([0.03, 0.006])) + draw.integers(-2, 3, size=2), times, 0.7)


@pytest.mark.parametrize("reached", [[True, True], [True, False], [False, True], [False, False]])
def test_every_way_to_a_discrepancy_gives_the_inner_products_that_all_rows_together_have(reached: list[bool]) -> None:
    draw = np.random.default_rng(37)
    logs, now = two_logs(draw, reached), any_discrepancy(draw)
    left = [np.where(np.isfinite(own.experiment.measured), draw.normal(size=(5, 20, 2)), 0.0) for own in logs]
    sums = ChannelSums(logs, left, now)
    for step in range(8):  # a channel at a time goes to another δ, T and s, and stays there or does not
        c, new = step % 2, any_discrepancy(draw)
        there = replace(now.moved(c, int(new.sizes[c]), int(new.memories[c])), times=tuple(t.copy() for t in now.times))
        for own, drawn in zip(there.times, new.times, strict=True):
            own[:, c] = drawn[:, c]
        others, parts = sums.others(c), sums.of_channel(c, there)
        total = sums.with_channel(c, others, parts)
        whole = weighed(logs, [[own[None]] for own in left], there.values)
        found = less_shared(total, np.full(2, there.share))
        np.testing.assert_allclose(found.inner, whole.inner, rtol=1e-9)
        assert found.log_det == pytest.approx(whole.log_det, rel=1e-9)
        if step % 3:
            sums.take(c, others, parts, total)
            now = there
            assert sums.total is total


@pytest.mark.parametrize("reached", [[True, True], [True, False]])
def test_what_windows_say_of_tries_differs_by_what_the_whole_density_differs_by(reached: list[bool]) -> None:
    """Beside the same shares of other friction, of which there are none here, summed over all windows."""
    draw = np.random.default_rng(41)
    logs = [Whitening(own.experiment, replace(own.unknowns, forms=own.unknowns.forms[:0])) for own in two_logs(draw, reached)]
    left = [np.where(np.isfinite(own.experiment.measured), draw.normal(size=(5, 20, 2)), 0.0) for own in logs]
    now, other = any_discrepancy(draw), any_discrepancy(draw)
    for c in range(2):
        there = now.moved(c, int(other.sizes[c]), int(other.memories[c]))
        sums = ChannelSums(logs, left, now)
        densities = sums.densities(c, sums.others(c), now)

        def of(at: Rungs, c: int = c, sums: ChannelSums = sums, densities=densities) -> float:  # type: ignore[no-untyped-def]
            return sum(float(densities(n, part).sum()) for n, part in enumerate(sums.of_channel(c, at)))

        def whole(at: Rungs) -> float:
            found = weighed(logs, [[own[None]] for own in left], at.values)
            return -0.5 * (float(found.inner[0, 0]) + found.log_det)

        assert of(there) - of(now) == pytest.approx(whole(there) - whole(now), rel=1e-8)
