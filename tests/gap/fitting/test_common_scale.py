"""Areas, flows, masses and forces twice as large: no reading changes, so what a fit knows of their scale is what the priors know."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from config.loading.load import LoadedRig, load_rig
from daemon.cli.main import main
from gap.data.channel_check import comparable
from gap.data.experiments import experiments_of
from gap.data.log_parts import load_parts
from gap.data.windows import Experiment
from gap.fitting.common_scale import at_own_scale
from gap.fitting.evaluation import Costing, evaluate
from gap.fitting.fit import Fit, covariance, unfitted
from gap.fitting.model import Model
from gap.fitting.nuisance import nuisances
from gap.settings import Settings
from sim_backend.plant import SimulatedRig

DATA_SHEET = [
    "--kind", "cylinder", "--bore", "16 mm", "--rod", "10 mm", "--stroke", "200 mm", "--mass", "5 kg", "--rated-flow", "10 l/min",
    "--supply", "70 bar", "--resolution", "5 um", "--noise", "5 um", "--chamber-pressures",
]  # fmt: skip
POWERS = {"bore": 0.5, "rod": 0.5}  # of the scale; what follows by units has one
OF_THE_SCALE = (
    *POWERS, "mass", "dead_volume_a", "dead_volume_b", "rated_flow", "bristle_stiffness", "bristle_damping", "friction", "excess",
    "coefficient", "conductance",
)  # fmt: skip


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> LoadedRig:
    folder = tmp_path_factory.mktemp("scale") / "bench"
    assert main(["new-rig", "bench", *DATA_SHEET, "-o", str(folder)]) == 0
    return load_rig(folder / "bench.yaml")


@pytest.fixture(scope="module")
def compared(rig: LoadedRig) -> tuple[list[str], list[Experiment]]:
    """Steps of the cylinder as a log."""
    folder = Path(rig.path).parent
    assert main(["simulate", str(rig.path), str(folder / "bench_joint_steps.yaml"), "-o", str(folder / "steps.mcap")]) == 0
    logs = [comparable(log, rig.rig) for log in load_parts([folder / "steps.mcap"], rig.rig)]
    names, experiments, _ = experiments_of(rig, logs, logs, Settings())
    return names, experiments


def model_of(rig: LoadedRig, names: list[str], scale: float = 1.0) -> Model:
    """Every constant free, and all that have the common scale times it."""
    free = nuisances(rig, frozenset(names))
    powers = [POWERS.get(item.key.rpartition(".")[2], 1.0) if item.key.rpartition(".")[2] in OF_THE_SCALE else 0.0 for item in free]
    return Model(rig.rig, free, np.array([item.start for item in free]) * scale ** np.array(powers))


def fitted(model: Model, experiments: list[Experiment]) -> tuple[Fit, Costing]:
    costs = Costing(np.full(len(experiments[0].columns), 1e9), 1.0)
    return unfitted(model, [evaluate(e, model, costs) for e in experiments], costs), costs


def test_a_larger_cylinder_with_more_of_everything_moves_alike(rig: LoadedRig) -> None:
    commands = 2.0 * np.sin(np.arange(1500) / 90.0)[:, None]
    runs = []
    for scale in (1.0, 1.7):
        plant = SimulatedRig(model_of(rig, ["axis.position"], scale).fitted_rig())
        plant.reset([0.1])
        runs.append(plant.run(commands, 0.001)["axis.position"])
    assert np.ptp(runs[0]) > 0.02
    assert runs[1] == pytest.approx(runs[0], abs=1e-9)


def test_the_scale_goes_back_to_where_the_priors_want_it(rig: LoadedRig, compared: tuple[list[str], list[Experiment]]) -> None:
    names, experiments = compared
    done, costs = fitted(model_of(rig, names, 1.08), experiments)
    found = at_own_scale(done, costs)
    assert found.model.theta == pytest.approx(model_of(rig, names).theta, rel=1e-3)
    assert found.cost == pytest.approx(done.cost, rel=1e-6)
    assert found.objective < done.objective - 5.0


def test_its_interval_is_the_priors_alone(rig: LoadedRig, compared: tuple[list[str], list[Experiment]]) -> None:
    """Posterior of the logarithm of the scale: the inverse of the sum of squares of (power × value / prior standard deviation). The
    cross-section of the bore moves by little else here."""
    names, experiments = compared
    done, costs = fitted(model_of(rig, names), experiments)
    found = at_own_scale(done, costs)
    larger = model_of(rig, names, np.e).theta
    way = np.log(larger / found.model.theta) * found.model.theta / found.model.scales
    assert all(np.abs(np.tensordot(way, part, 1)).max() < 1e-6 * np.abs(part).max() for part in found.columns)
    from_priors = float(way @ way) ** -0.5
    bore = next(k for k, free in enumerate(found.model.free) if free.key.endswith("bore"))
    sd = float(np.sqrt(covariance(found, costs)[bore, bore])) / found.model.theta[bore]
    assert sd > 0.99 * 0.5 * from_priors
    assert sd < 2.0 * 0.5 * from_priors


def test_where_one_number_is_held_the_logs_show_the_scale(rig: LoadedRig, compared: tuple[list[str], list[Experiment]]) -> None:
    """With a mass that stays as it is the others cannot go together."""
    names, experiments = compared
    model = model_of(rig, names)
    mass = next(k for k, free in enumerate(model.free) if free.key.endswith("mass"))
    held = replace(model, free=(*model.free[:mass], *model.free[mass + 1 :]), theta=np.delete(model.theta, mass))
    done, costs = fitted(held, experiments)
    assert at_own_scale(done, costs) is done
