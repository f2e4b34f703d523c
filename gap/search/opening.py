"""From logs to the model a search begins with: the log in windows, the rig file compared with them, its constants refitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from config.loading.load import LoadedRig
from config.progress import Progress
from gap.data.measured import Measured, compared
from gap.data.noise import noise_floors
from gap.data.strata import chosen
from gap.data.windows import Experiment, left_in, prepare, velocities
from gap.fitting.convergence import CONVERGED, REFIT_STEPS, settled
from gap.fitting.evaluation import Evaluation, costing, evaluate, judged, mean_cost
from gap.fitting.fit import Fit, fit, unfitted
from gap.fitting.model import Model
from gap.fitting.simulate import remembering, some
from gap.search.search_state import GateSearch
from gap.search.settings import Settings
from gap.signatures.window_length import window_length_s


def experiments_of(
    loaded: LoadedRig, fit_logs: Sequence[Measured], holdout_logs: Sequence[Measured], settings: Settings
) -> tuple[list[str], list[Experiment], list[Experiment]]:
    """Channels that some fit log has, and the logs cut into windows; a log has no values in a channel it lacks. LogError where the windows
    left in all fit logs, or in all hold-out logs, are too few."""
    every = [*fit_logs, *holdout_logs]
    names = compared(dict.fromkeys(name for log in fit_logs for name in log.channels), loaded.rig)
    sigma = noise_floors(every, loaded.rig)
    window_s = settings.window_s or window_length_s(loaded.rig, every, sigma)
    cut = [prepare(log, loaded.rig, sigma, window_s, names, settings.workers) for log in every]
    return names, left_in(cut[: len(fit_logs)], "--log"), left_in(cut[len(fit_logs) :], "--holdout")


def started(
    model: Model, experiments: list[Experiment], held: list[Experiment], channels: frozenset[str], progress: Progress
) -> tuple[GateSearch, tuple[Evaluation, ...]]:
    """The rig file as it is, then with its constants refitted."""
    progress("comparing the rig file with the logs")
    vector, numbers = model.vector(), chosen([velocities(e) for e in experiments])
    few = [remembering(some(e, n), vector) for e, n in zip(experiments, numbers, strict=True)]
    free = [evaluate(e, model, None) for e in (*few, *held)]
    costs = costing([*few, *held], [e.left for e in free])
    counted = [judged(e.experiment, e.readings, e.projection, costs) for e in free]
    now, nominal = counted[: len(few)], tuple(counted[len(few) :])
    progress(f"hold-out: {mean_cost(nominal):.4g} noise floors; sensitivities of {len(model.free)} constants")
    start = unfitted(model, now, costs)
    known = [e.projection for e in now]
    done: Fit = fit(model, few, costs, range(len(model.free)), start.jacobian, REFIT_STEPS, known, CONVERGED)
    few = [remembering(e, done.model.vector()) for e in few]
    again = tuple(evaluate(e, done.model, costs, projection) for e, projection in zip(few, known, strict=True))
    done, costs = settled(replace(done, evaluations=again), few, costs, REFIT_STEPS)
    refitted = tuple(evaluate(e, done.model, costs) for e in held)
    progress(f"hold-out with refitted constants: {mean_cost(refitted):.4g} noise floors")
    return GateSearch(few, held, costs, channels, start, done, refitted, refitted, experiments[0].workers), nominal
