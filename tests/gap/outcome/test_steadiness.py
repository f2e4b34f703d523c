"""Constants log by log: Cochran's Q by hand, its rate of false alarms with remembered noise, and what the verdict says of it."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from config.loading.load import LoadedRig, rig_from_text
from gap.data.measured import on_grid
from gap.find import search_gap
from gap.fitting.evaluation import Costing, Evaluation
from gap.fitting.model import Free
from gap.outcome.steadiness import Steadiness, in_words, logs_by_themselves, unsteady
from gap.settings import Settings
from tests.support.gap import axis_logs

WINDOWS, SAMPLES = 40, 60
ONE = Free(("link", "payload_kg"), "plant.link.payload", "kg", 10.0, 0.5, 0.0, 100.0, True)
TWO = Free(("joints", "axis", "mass"), "plant.joints.axis.mass", "kg", 95.0, 2.0, 0.0, 200.0, True)
FILES = ("fit.csv", "hold.csv")


def constant(free: Free, values: tuple[float, ...], sds: tuple[float, ...]) -> Steadiness:
    return Steadiness(free, FILES[: len(values)], np.array(values), np.array(sds))


def test_of_two_logs_p_is_that_of_the_difference() -> None:
    """A normal difference of standard deviation √(0.3² + 0.4²) = 0.5, two-sided."""
    assert constant(ONE, (10.0, 11.2), (0.3, 0.4)).p == pytest.approx(2 * norm.sf(1.2 / 0.5))


def test_of_many_constants_one_must_differ_by_more() -> None:
    odd, even = constant(ONE, (10.0, 11.35), (0.3, 0.4)), constant(TWO, (95.0, 95.1), (0.1, 0.1))
    assert odd.p == pytest.approx(0.0069, abs=1e-4)
    assert unsteady([odd]) == [odd]
    assert unsteady([even, odd]) == []
    clear = constant(ONE, (10.0, 12.0), (0.3, 0.4))
    assert unsteady([even, clear]) == [clear]


class Bench:
    """Logs of one channel in 40 windows of 60 samples, two constants, noise that remembers ten samples."""

    def __init__(self, seed: int) -> None:
        self.draw = np.random.default_rng(seed)
        time = np.arange(WINDOWS * SAMPLES) / 250.0
        self.signatures = 0.3 * np.stack([np.sin(2 * np.pi * 0.7 * time), np.sin(2 * np.pi * 1.3 * time + 1)]).reshape(2, WINDOWS, SAMPLES)

    def log(self, name: str, away: tuple[float, float]) -> tuple[Evaluation, np.ndarray]:
        """A log whose constants are `away` from the common ones, in prior standard deviations."""
        white, keep = self.draw.standard_normal(WINDOWS * SAMPLES + 200), 0.9
        noise = np.zeros(white.size)
        for k in range(1, white.size):
            noise[k] = keep * noise[k - 1] + np.sqrt(1 - keep**2) * white[k]
        left = noise[200:].reshape(WINDOWS, SAMPLES) + np.tensordot(np.array(away), self.signatures, 1)
        log = SimpleNamespace(path=Path(name))
        experiment: Any = SimpleNamespace(measured=np.zeros((WINDOWS, SAMPLES, 1)), columns=(0,), log=log)
        return Evaluation(experiment, None, left, left, (left**2).mean(axis=1), np.ones(1)), self.signatures  # type: ignore[arg-type]

    def searched(self, away: tuple[float, float]) -> list[Steadiness]:
        first, second = self.log("fit.csv", (0.0, 0.0)), self.log("hold.csv", away)
        model: Any = SimpleNamespace(free=(ONE, TWO), theta=np.array([10.0, 95.0]))
        logs, columns = zip(first, second, strict=True)
        return logs_by_themselves(model, logs, columns, Costing(np.array([6.0]), 1.0), [0, 1], [0, 1])


def test_noise_that_remembers_is_no_difference() -> None:
    """1 % of false alarms is asked for, over both constants, with noise that remembers ten samples."""
    bench = Bench(1)
    runs = [bench.searched((0.0, 0.0)) for _ in range(300)]
    assert sum(bool(unsteady(found)) for found in runs) <= 6
    spread = np.std([found[0].values[1] for found in runs])
    assert spread < np.mean([found[0].sds[1] for found in runs]) < 1.4 * spread


def test_a_constant_that_differs_is_found_and_no_other() -> None:
    bench = Bench(2)
    runs = [bench.searched((4.0, 0.0)) for _ in range(40)]
    named = [[s.free for s in unsteady(found)] for found in runs]
    assert sum(names[:1] == [ONE] for names in named) >= 38
    assert sum(TWO in names for names in named) <= 2
    assert np.mean([found[0].values for found in runs], axis=0) == pytest.approx([10.0, 12.0], abs=0.6), "drawn towards the common value"


@pytest.mark.slow
def test_friction_too_small_to_be_named_makes_the_damping_depend_on_the_speed() -> None:
    """The damping is wrong, and a Coulomb friction is missing that more damping stands in for: more of it where the axis is slow."""
    text = axis_logs.axis_text("coulomb_friction")
    machine = axis_logs.axis_text().replace("friction: 20.39 N", "friction: 0.02 N").replace("coefficient: 203.5", "coefficient: 220")
    loaded, truth = LoadedRig(rig_from_text(text), text, "axis.yaml"), rig_from_text(machine)
    runs = (("fast.csv", 7003, 1.0), ("slow.csv", 7004, 0.3))
    logs = [on_grid(Path(name), axis_logs.simulated(truth, seed, amplitude=a), loaded.rig, name) for name, seed, a in runs]
    found = search_gap(loaded, logs[:1], logs[1:], lambda line: None, Settings(propose=False))
    assert (found.verdict.word, found.verdict.confirmed) == ("parameter_mismatch", False)
    assert "plant.effects.0.coefficient is not the same in every log" in found.verdict.why
    fast, slow = (row["value"] for row in found.content["parameters"]["plant.effects.0.coefficient"]["by_log"])
    assert 220 < fast < slow


def test_the_sentence_names_constant_and_logs() -> None:
    said = in_words(unsteady([constant(ONE, (10.0, 12.0), (0.3, 0.4))]))
    assert said == "plant.link.payload is not the same in every log (10 ± 0.3 kg in fit.csv and 12 ± 0.4 kg in hold.csv; p = 6e-05)"
