"""Numbers of the rig file are tried where they would just show, too: along straight lines to there, which promise marginal likelihoods."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from gap.data.measured import Array
from gap.evidence.lines import followed, joined
from gap.evidence.promises import _promised
from gap.evidence.score.changed import Changed, changeable
from gap.evidence.score.coordinates import phi_of
from gap.evidence.screening import Promise, Screen
from gap.evidence.search_state import EvidenceSearch
from gap.evidence.secants import Secant, secants_to
from tests.gap.evidence.test_visible_sizes import SAMPLES, White, linear_base
from tests.support.gap import axis_logs
from tests.support.gap.constants_fitted import constants_fitted

RANGE_SDS = 3.0
HYSTERESIS = "valve_hysteresis at axis changed (half_width)"
STATED, TRUE = 0.002, 0.02


@dataclass(frozen=True)
class WhiteAnd(White):
    """A log that leaves `y`."""

    y: Array

    def left(self, readings: Any) -> list[Array]:
        return [self.y[None, :, None]]


@pytest.mark.parametrize("along_its_own", [True, False])
def test_the_promise_is_that_of_quadrature(along_its_own: bool) -> None:
    draw = np.random.default_rng(11)
    constants = 0.5 * draw.standard_normal((3, SAMPLES))
    base = linear_base(constants)
    suspect = next(c for c in changeable(base.model.rig, base.model.free))
    k, free = suspect.number_in(base.model), suspect.free
    wide_stretch = np.log1p(free.scale / free.start)  # of the constant's logarithm, where it is its stated value
    own = constants[k] / wide_stretch if suspect.free.prior else constants[k] * free.scale / free.start / wide_stretch
    column = own if along_its_own else draw.standard_normal(SAMPLES)
    y = 1.5 * column + 0.3 * draw.standard_normal(SAMPLES)
    secant = None if along_its_own else Secant(suspect, 2.0 * free.start, (column[None, :, None],))
    promise = Screen(WhiteAnd(y), base, (), [secant] if secant else ()).changed(suspect, secant)  # type: ignore[arg-type]

    ends = [(end - free.start) / free.scale for end in (free.low, free.high)]
    prior = norm(0.0, max(map(abs, ends)) / RANGE_SDS)
    others = np.delete(constants, k, axis=0)
    noise = multivariate_normal(np.zeros(SAMPLES), np.eye(SAMPLES) + others.T @ others)
    a = np.linspace(max(ends[0], -4.0), min(ends[1], 6.0), 4001)
    with_it = np.trapezoid(np.exp(noise.logpdf(y - a[:, None] * column)) * prior.pdf(a), a) / (prior.cdf(ends[1]) - prior.cdf(ends[0]))
    without = multivariate_normal(np.zeros(SAMPLES), np.eye(SAMPLES) + constants.T @ constants).logpdf(y)
    assert promise.log_z == pytest.approx(np.log(with_it) - without, abs=0.02)


@pytest.fixture(scope="module")
def search(tmp_path_factory: pytest.TempPathFactory) -> EvidenceSearch:
    """The constants alone, fitted to a machine whose valve has ten times the hysteresis that its file states."""
    text = axis_logs.axis_text()
    stated, true = (
        text.replace("  effects:\n", f"  effects:\n    - {{effect: valve_hysteresis, where: axis, half_width: {width}}}\n", 1)
        for width in (STATED, TRUE)
    )
    return constants_fitted(Path(tmp_path_factory.mktemp("logs")), stated, true, 72)


def hysteresis(search: EvidenceSearch) -> Changed:
    return next(s for s in changeable(search.rig, search.nominal.model.free) if s.label == HYSTERESIS)


@pytest.mark.slow
def test_a_secant_ends_at_the_readings_of_its_value(search: EvidenceSearch) -> None:
    seen, base, suspect = search.seen, search.null, hysteresis(search)
    (secant,) = secants_to(seen, base, {suspect.label: TRUE}, [suspect])
    model, lines = joined(base, Promise(suspect, 0.0, secant))
    there = suspect.with_value(model, TRUE)
    step = phi_of(there) - phi_of(model)
    for before, jacobian, after in zip(seen.left(base.at.readings), lines, seen.left(seen.readings(there)), strict=True):
        assert before - np.tensordot(step, jacobian, 1) == pytest.approx(after, abs=1e-6)


@pytest.mark.slow
def test_nothing_is_tried_where_the_number_stands_or_beyond_its_range(search: EvidenceSearch) -> None:
    suspect = hysteresis(search)
    here = suspect.value_in(search.null.model)
    for value in (here, 1.1 * here, np.inf, 2.0 * suspect.free.high):
        assert secants_to(search.seen, search.null, {suspect.label: value}, [suspect]) == []


@pytest.mark.slow
def test_lines_about_the_stated_number_do_not_lead_to_it_and_those_of_the_search_do(search: EvidenceSearch) -> None:
    suspect = hysteresis(search)
    _, (waiting,) = _promised(search, search.null, [suspect], search.null)
    assert isinstance(waiting.promise.signature, Secant)
    assert waiting.lines is not None
    about = followed(search.seen, search.null, Promise(suspect, 0.0))
    assert waiting.lines.log_z > about.log_z + 10.0
    assert suspect.value_in(waiting.lines.model) == pytest.approx(TRUE, rel=0.3)
