"""The size from which a suspect would be as probable as not, against the marginal likelihood of small linear problems, by quadrature and by
the covariance of the readings; and against a simulated machine that has the effect in twice and in half that size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from config.loading.load import LoadedRig, rig_from_text
from gap.data.measured import Array
from gap.evidence.noise.noise_model import Weighed
from gap.evidence.score.changed import changeable
from gap.evidence.screening import LinearSignature, Screen, signatures_of
from gap.evidence.visible_sizes import changed_by, visible_sizes
from gap.evidence.where_shown import shown_from
from gap.fitting.model import Model
from gap.fitting.nuisance import nuisances
from gap.suspects.candidates import Candidate, candidates
from tests.support.gap import axis_logs
from tests.support.gap.constants_fitted import constants_fitted

NEEDED = 2.6  # ln of odds of 1 in 13
SAMPLES = 60
RANGE_SDS = 3.0  # prior standard deviations to the far end of a plausible range, as the method's page has it


@dataclass(frozen=True)
class White:
    """Logs of white noise alone, for Screen."""

    def left(self, readings: Any) -> list[Array]:
        return [np.zeros((1, SAMPLES, 1))]

    def weighed(self, rows: Sequence[Sequence[Array]], discrepancy: Any) -> Weighed:
        flat = np.concatenate([block.reshape(len(block), -1) for block in rows[0]])
        return Weighed(flat @ flat.T, 0.0)


def linear_base(columns: Array) -> Any:
    """A fitted set of the axis at its own constants whose readings hang on them by `columns`, numbers × samples."""
    text = axis_logs.axis_text()
    rig = rig_from_text(text)
    free = nuisances(LoadedRig(rig, text, "axis.yaml"), frozenset({"axis.position"}))[-len(columns) :]
    model = Model(rig, free, np.array([f.start for f in free]))
    at = SimpleNamespace(readings=None, jacobian=[columns[:, None, :, None]], discrepancy=None)
    return SimpleNamespace(at=at, model=model, log_z=0.0)


def of_axis(effect: str) -> Candidate:
    return next(c for c in candidates(axis_logs.axis_rig(), frozenset({"axis.position"})) if c.effect == effect)


@pytest.mark.parametrize("strength", [3.0, 30.0])
def test_an_effect_of_that_size_gains_what_it_needs(strength: float) -> None:
    draw = np.random.default_rng(3)
    constants, column = draw.standard_normal((2, SAMPLES)), strength * draw.standard_normal(SAMPLES)
    base, suspect = linear_base(constants), of_axis("valve_deadband")
    line = LinearSignature(suspect, (suspect.free[0].scale,), (column[None, None, :, None],))
    size = shown_from(Screen(White(), base, [line]), line, NEEDED)  # type: ignore[arg-type]
    free = suspect.free[0]
    ends = [(end - free.start) / free.scale for end in (free.low, free.high)]
    sd = max(map(abs, ends)) / RANGE_SDS
    noise = multivariate_normal(np.zeros(SAMPLES), np.eye(SAMPLES) + constants.T @ constants)
    y = size * column
    prior = norm(0.0, sd)

    width = 1.0 / float(np.linalg.norm(column))
    a = np.linspace(max(ends[0], size - 12.0 * width), min(ends[1], size + 12.0 * width), 4001)
    density = np.exp(noise.logpdf(y - a[:, None] * column) - noise.logpdf(y)) * prior.pdf(a)
    inside = prior.cdf(ends[1]) - prior.cdf(ends[0])
    assert 0.0 < size < ends[1]
    assert np.log(np.trapezoid(density, a) / inside) == pytest.approx(NEEDED, abs=0.02)


def test_a_number_changed_by_that_much_gains_what_it_needs() -> None:
    """With the wide prior in the place of the narrow one the readings' covariance is another: no Schur complement."""
    constants = np.random.default_rng(5).standard_normal((3, SAMPLES))
    base = linear_base(constants)
    suspect = next(c for c in changeable(base.model.rig, base.model.free))
    number = suspect.number_in(base.model)
    free, model = suspect.free, base.model
    size = changed_by(Screen(White(), base, ()), model, suspect, NEEDED)  # type: ignore[arg-type]
    wide = np.ones(len(constants))
    wide[number] = (max(free.high - free.start, free.start - free.low) / free.scale / RANGE_SDS) ** 2
    phi = np.log1p(size / free.start) / np.log1p(free.scale / free.start)  # a positive constant
    y = phi * constants[number]
    with_it, without = (
        multivariate_normal(np.zeros(SAMPLES), np.eye(SAMPLES) + constants.T @ (v[:, None] * constants)).logpdf(y)
        for v in (wide, np.ones(len(constants)))
    )
    assert with_it - without == pytest.approx(NEEDED, abs=1e-6)


@pytest.mark.slow
def test_a_machine_with_twice_that_size_shows_it_and_one_with_half_does_not(tmp_path: Path) -> None:
    """A dead band, which is not proportional to its size."""
    text = axis_logs.axis_text()
    search = constants_fitted(tmp_path, text, text)
    suspect = of_axis("valve_deadband")
    (claim,) = visible_sizes(search.seen, search.null, [suspect], NEEDED)
    assert 0.0 < claim.size < 0.02
    for times, shows in ((2.0, True), (0.5, False)):
        line = f"  effects:\n    - {{effect: valve_deadband, where: axis, overlap: {times * claim.size:.6g}}}\n"
        there = constants_fitted(tmp_path, text, text.replace("  effects:\n", line, 1))
        lines = signatures_of(there.seen, there.null, [replace(suspect)])
        gain = max(Screen(there.seen, there.null, lines).missing(one).log_z for one in lines) - there.null.log_z
        assert (gain > NEEDED) == shows, (times, gain)
