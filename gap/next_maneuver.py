"""Which shipped maneuver would tell two explanations apart best: T-optimal, with the rival allowed to refit.

T = ‖P (y_k − y_l) / σ‖², P taking out what the rival's own parameters, the rig's uncertain constants and the initial states can do;
the smaller of T(k, l) and T(l, k) counts. The expected t is about √T / 2.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from config.errors import ConfigError, LongreachError
from config.load import LoadedRig
from config.rig import Rig
from gap.candidates import candidates
from gap.closed_loop import measured_on
from gap.fit import Costing, evaluate, projected, sensitivities
from gap.measured import Measured
from gap.model import Free, Model
from gap.noise import noise_floors
from gap.nuisance import nuisances
from gap.windows import default_window_s, prepare

QUICK = ("joint_steps", "staircase", "fast_strokes", "slow_triangle")
SHIPPED = ("slow_triangle", "staircase", "joint_steps", "fast_strokes", "multisine", "paper_line", "sine_sweep", "hold", "jog")
LEAST_T = 9.0  # below this everywhere, only another sensor can separate the two
WANTED_T = 5.0

Tell = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Rival:
    """One explanation: the rig with it, and its free parameters there."""

    name: str
    rig: Rig
    free: tuple[Free, ...]


@dataclass(frozen=True, slots=True)
class Proposal:
    """One maneuver and how well it would separate the two."""

    name: str
    separates: tuple[str, str]
    T: float
    duration_s: float

    @property
    def expected_t(self) -> float:
        return float(np.sqrt(self.T) / 2)

    @property
    def repeats(self) -> int | None:
        """Runs needed for t > 5; None when no number of them would do."""
        return int(np.ceil((WANTED_T / self.expected_t) ** 2)) if self.T >= LEAST_T else None

    def as_dict(self) -> dict[str, Any]:
        if self.T < LEAST_T:
            why = "no shipped maneuver separates the two: fit another sensor (chamber pressures separate force from flow)"
        else:
            why = f"expected t {self.expected_t:.1f} in {self.duration_s:.0f} s; {self.repeats} run(s) for t > {WANTED_T:g}"
        return asdict(self) | {
            "why": why,
            "expected_t": round(self.expected_t, 2),
            "separates": list(self.separates),
            "repeats": self.repeats,
        }


def propose(loaded: LoadedRig, first: Rival, second: Rival, tell: Tell, maneuvers: Sequence[str] = SHIPPED) -> list[Proposal]:
    """All maneuvers the rig allows, best T per second first."""
    found = []
    for name in maneuvers:
        try:
            logs = [measured_on(rival.rig, name) for rival in (first, second)]
            T = min(_distance(loaded, logs[0], first, second), _distance(loaded, logs[1], second, first))
        except LongreachError as refused:
            tell(f"  {name}: not on this rig ({refused.refusal.what})")
            continue
        found.append(Proposal(name, (first.name, second.name), T, logs[0].duration_s))
        tell(f"  {name}: expected t {found[-1].expected_t:.1f} in {found[-1].duration_s:.0f} s")
    return sorted(found, key=lambda p: -min(p.T, 4 * WANTED_T**2) / p.duration_s)


def _distance(loaded: LoadedRig, log: Measured, truth: Rival, rival: Rival) -> float:
    """T of one log without noise, made by one explanation, for the other; less what the truth itself leaves by numerics."""
    channels = list(log.channels)
    sigma = noise_floors([log], loaded.rig)
    experiment = prepare(log, rival.rig, sigma, default_window_s(rival.rig), channels)
    free = nuisances(loaded, frozenset(channels)) + rival.free
    model = Model(rival.rig, free, np.array([item.start for item in free]))
    costs = Costing(np.full(len(channels), np.inf), 1.0)
    now = evaluate(experiment, model, costs)
    own = evaluate(experiment, Model(truth.rig, (), np.empty(0)), costs)
    columns = projected(now, sensitivities(model, [experiment], range(len(free)), [now.readings])[0]).reshape(len(free), -1)
    prior = np.diag([1.0 if item.prior else 1e-6 for item in free])
    e = now.left.ravel()
    shift = np.linalg.solve(columns @ columns.T + prior, columns @ e)
    rest = e - shift @ columns
    return max(float(rest @ rest + shift @ prior @ shift) - float(np.sum(own.left**2)), 0.0)


def rival_of(loaded: LoadedRig, effect: str, where: str, parameters: Mapping[str, float] | None = None) -> Rival:
    """The rig with one effect at given parameters, or at its typical size. ConfigError when the rig has no place for it."""
    assert loaded.rig.plant is not None
    possible = candidates(loaded.rig, frozenset(loaded.rig.plant.sensors))
    chosen = next((c for c in possible if (c.effect, c.where) == (effect, where)), None)
    if chosen is None:
        advice = f"Possible: {', '.join(sorted({c.label for c in possible}))}."
        raise ConfigError("this effect cannot be added to the rig", value=f"{effect} at {where}", where=loaded.path, next_step=advice)
    base = Model(loaded.rig, (), np.empty(0)).with_effect(chosen.entry, chosen.free)
    values = [(parameters or {}).get(free.key, start) for free, start in zip(chosen.free, chosen.starts[0], strict=True)]
    model = base.with_theta(np.array(values))
    free = tuple(replace(item, start=float(value)) for item, value in zip(base.free, values, strict=True))
    return Rival(chosen.label, model.fitted_rig(), free)
