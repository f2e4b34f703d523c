"""The unnamed remainder put into the rig file when asked: as a table, and only where the hold-out falls with it.

Which variable carries the imbalance and where the knots lie comes from the fit logs, and so do the forces at the knots, by simulation
with all else held. The hold-out only judges. The verdict is that of the model without the table.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from config.progress import Progress
from config.schema.rig import Rig
from gap.balance.balances import obstacles
from gap.balance.discrepancy import discrepancy
from gap.data.measured import Measured
from gap.fitting.compare import paired_t
from gap.fitting.evaluation import Evaluation, evaluate, mean_cost
from gap.fitting.fit import Fit, fit
from gap.outcome.held_constants import LEAST_DROP
from gap.outcome.model_file import with_effect_line
from gap.outcome.search_state import SearchState
from gap.outcome.written import file_model
from gap.remainder.remainder_table import BALANCE, UNITS, RemainderTable, tables

LEAST_FALL_T = 2.0  # of the hold-out's fall: one table was asked for, not the best of many candidates


def kept_remainder(
    text: str, state: SearchState, rest: dict[str, Any], final: Sequence[Evaluation], progress: Progress
) -> tuple[str, dict[str, Any]]:
    """The improved rig file's text with the table in it, and what findings.json says: `kept` true with the table and the hold-out before
    and after, or false with `why`; then the text is as it was.

    `rest`: what gap.remainder.remainder said of the hold-out; `final`: the hold-out with the file as `text` has it.
    """
    rig, logs = file_model(text).rig, [e.log for e in state.experiments]
    located = str(rest["discrepancy"]["equation"]) if rest["discrepancy"] else BALANCE
    found = discrepancy(logs, rig, located, uneven=0.0) if located.startswith(BALANCE) else None
    choices = tables(found, rig) if found else []
    why = _hindrance(located, found, choices, logs, rig)
    if why:
        return text, _not_kept(why, progress)
    progress(f"fitting the unnamed remainder over {', '.join(f'{table.variable} ({table.acts})' for table in choices)}")
    done = [(_fitted(text, state, table), table) for table in choices]
    best, table = min(done, key=lambda pair: pair[0].cost)
    return _judged(text, state, best, table, final, progress)


def _hindrance(located: str, found: dict[str, Any] | None, choices: Sequence[RemainderTable], logs: Sequence[Measured], rig: Rig) -> str:
    """Why no table can be tried; empty when one can."""
    if not located.startswith(BALANCE):
        return f"it is in the {located}; only a force on a joint can stand in the rig file"
    if found is None:
        reasons = "; ".join(f"{joint}: {why}" for joint, why in obstacles(logs[0], rig).items())
        return f"no force balance can be formed ({reasons or 'no joint moves long enough'}); log what is lacking and search again"
    joint = str(found["equation"]).removeprefix(BALANCE)
    assert rig.plant is not None
    if rig.plant.joints[joint].is_imposed:
        return f"the motion of {joint} is imposed, and no force changes it"
    if any(e.effect == "unnamed_remainder" and e.where == joint for e in rig.plant.effects):
        return f"the rig file has an unnamed_remainder at {joint} already; delete it and search again"
    variables = "velocity, position, command or pressure difference of the joint"
    return "" if choices else f"on the fitted logs none of {variables} carries the imbalance of the {found['equation']}"


def _fitted(text: str, state: SearchState, table: RemainderTable) -> Fit:
    """The forces at the knots, fitted by simulation from those of the balance, all else as the file has it."""
    base = file_model(text)
    model = base.with_effect(table.entry(table.force), table.free(base.rig))
    return fit(model, state.experiments, state.costs)


def _judged(
    text: str, state: SearchState, best: Fit, table: RemainderTable, final: Sequence[Evaluation], progress: Progress
) -> tuple[str, dict[str, Any]]:
    """On the hold-out, simulated with the file as it would be written."""
    before = mean_cost(final)
    line = table.line(best.model.theta, "")
    after = _on_holdout(with_effect_line(text, line), state)
    reached, t = mean_cost(after), paired_t(final, after)
    numbers = {"holdout_before": before, "holdout_after": reached, "t": round(t, 2)}
    if not (before - reached >= LEAST_DROP and t > LEAST_FALL_T):
        change = f"from {before:.4g} to {reached:.4g} noise floors (t {t:.1f})"
        return text, _not_kept(
            f"with a table of {table.acts} over {table.variable} the hold-out goes {change}: no clear fall", progress
        ) | numbers
    remark = (
        f"unnamed remainder, not physics: {table.acts} seen over {table.seen_over}; hold-out {before:.4g} to {reached:.4g} noise floors"
    )
    progress(f"kept an {remark}")
    return with_effect_line(text, table.line(best.model.theta, remark)), _as_kept(best, table) | numbers


def _as_kept(best: Fit, table: RemainderTable) -> dict[str, Any]:
    """For findings.json, SI."""
    units = UNITS[table.motion]
    return {
        "kept": True,
        "effect": "unnamed_remainder",
        "where": table.joint,
        "variable": {"name": table.variable, "at": [float(f"{at:.6g}") for at in table.knots], "unit": units[table.variable]},
        table.acts: {"value": [float(f"{value:.6g}") for value in best.model.theta], "unit": units["force"]},
        "drives": table.entry(best.model.theta).drives,
    }


def _on_holdout(text: str, state: SearchState) -> tuple[Evaluation, ...]:
    model = file_model(text)
    return tuple(evaluate(experiment, model, state.costs) for experiment in state.holdouts)


def _not_kept(why: str, progress: Progress) -> dict[str, Any]:
    progress(f"the unnamed remainder is not kept: {why}")
    return {"kept": False, "why": why}
