"""The acceptance table: every claim of the paper, computed now."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from config.schema.rig import Rig
from tuning.paper import rows_cycles, rows_figures, rows_joint, rows_link, rows_motion
from tuning.paper.row import ClaimRow, RowMaker

MAKERS: tuple[RowMaker, ...] = (
    rows_joint.ratings,
    rows_joint.equation_1,
    rows_joint.equation_4,
    rows_joint.loop_margins,
    rows_joint.equations_2_3,
    rows_cycles.intersections,
    rows_cycles.exact_cycles,
    rows_cycles.five_hertz,
    rows_figures.thermal_gain,
    rows_figures.warm_up_run,
    rows_figures.rotary_amplitudes,
    rows_figures.prismatic_amplitudes,
    rows_link.frequencies,
    rows_link.ratio_of_frequencies,
    rows_link.energy,
    rows_link.newton_against_lagrange,
    rows_motion.straight_line,
    rows_motion.kinematics,
    rows_motion.equation_14,
    rows_motion.unfiltered,
    rows_motion.three_term,
    rows_motion.adaptive,
    rows_motion.coupled,
    rows_cycles.reflected_tip,
    rows_cycles.lag_lead_margins,
    rows_cycles.books_rule,
    rows_figures.unequal_cylinder,
)


def acceptance_table(rig: Rig, say: Callable[[ClaimRow], None] = lambda row: None) -> list[ClaimRow]:
    """All 27 rows, in order; `say` gets each as soon as it is known."""
    return list(_said(rig, say))


def _said(rig: Rig, say: Callable[[ClaimRow], None]) -> Iterator[ClaimRow]:
    for make in MAKERS:
        row = make(rig)
        say(row)
        yield row
