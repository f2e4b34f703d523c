"""Sensitivities along the posterior's axes: what the normal of a fit says of ln p around it is what simulations there say."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from gap.data.measured import Array
from gap.evidence.judgement.judge import on_all_logs, together
from gap.evidence.refinement import finished
from gap.evidence.score.coordinates import phi_of, theta_of
from gap.evidence.score.hypothesis import Hypothesis, Seen, about, log_density, posterior
from gap.evidence.score.prior import prior_of
from gap.evidence.sensitivity import renewed
from gap.evidence.stages import refitted
from tests.gap.evidence.test_effect_free import opened, opened_and_held, rig_file
from tests.support.gap import axis_logs
from tests.support.gap.maxwell_axis import maxwell_axis


def fitted(folder: Path) -> tuple[Seen, Hypothesis]:
    """The constants of an axis fitted to a log of its own."""
    loaded = rig_file()
    search, _ = opened(folder, loaded, [axis_logs.simulated(loaded.rig, 31 + k, 6.0) for k in (0, 1)])
    search = refitted(search, lambda line: None)
    return search.seen, search.null


def density_at(seen: Seen, at: Hypothesis, phi: Array) -> float:
    """ln p(y, φ) with the fit's discrepancy, from a simulation of its own."""
    model = at.model.with_theta(theta_of(at.model, phi))
    return log_density(seen, replace(at.at, model=model, readings=seen.readings(model)))


def test_one_standard_deviation_along_any_axis_costs_a_half(tmp_path: Path) -> None:
    """Stiff axes and soft ones, which are small differences of the columns of single constants."""
    seen, fit = fitted(tmp_path)
    point = renewed(seen, fit.at)
    at, phi, prior = posterior(seen, point), phi_of(point.model), prior_of(point.model)
    stiffness, axes = np.linalg.eigh(at.precision)
    assert stiffness[-1] > 1e4 * stiffness[0]
    for k, axis in enumerate(axes.T):
        move = axis / np.sqrt(stiffness[k])
        if np.any(phi + np.abs(move) > prior.high) or np.any(phi - np.abs(move) < prior.low):
            continue
        fallen = density_at(seen, fit, phi) - 0.5 * (density_at(seen, fit, phi + move) + density_at(seen, fit, phi - move))
        assert 0.25 < fallen < 1.0, (k, stiffness[k], fallen)


def test_a_product_that_stays_as_it_is_lies_on_a_straight_line(tmp_path: Path) -> None:
    """Along a soft axis two standard deviations cost four times what one does: nothing bends into the stiff ones."""
    seen, fit = fitted(tmp_path)
    point = renewed(seen, fit.at)
    stiffness, axes = np.linalg.eigh(posterior(seen, point).precision)
    phi, prior = phi_of(point.model), prior_of(point.model)
    move = axes[:, 0] / np.sqrt(stiffness[0])
    move = move * min(1.0, 0.4 * np.min(np.where(move != 0.0, np.minimum(prior.high - phi, phi - prior.low) / np.abs(move), np.inf)))
    middle = density_at(seen, fit, phi)
    near, far = (middle - 0.5 * (density_at(seen, fit, phi + s * move) + density_at(seen, fit, phi - s * move)) for s in (1.0, 2.0))
    assert 3.0 < far / near < 6.0


def spread(seen: Seen, at: Hypothesis) -> Array:
    """Standard deviations of all numbers."""
    return np.sqrt(np.diag(np.linalg.inv(posterior(seen, at.at).precision)))


def test_a_stuck_joint_in_the_hold_out_makes_no_number_surer_than_it_is(tmp_path: Path) -> None:
    """Where a joint sticks and slips, a short move tells of single events: the set on all logs would be ten times too sure of its numbers
    until sensitivities are taken again."""
    search, _, held = opened_and_held(tmp_path, rig_file(), [maxwell_axis(31 + k, 6.0) for k in (0, 1)])
    search = refitted(search, lambda line: None)
    judges = about(held, search.seen.scales, search.seen.model, search.seen.counts)
    both, judged = together(search.seen, judges), on_all_logs(search.seen, search.null, judges)
    ended = finished(both, (), judged.at)
    np.testing.assert_array_less(np.abs(np.log(spread(both, judged) / spread(both, ended))), np.log(1.5))
