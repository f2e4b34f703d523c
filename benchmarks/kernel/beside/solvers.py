"""scipy's stiff solvers on the kernel's own rates: the tight reference, and what LSODA and BDF cost at the same accuracy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import BDF, LSODA, Radau

from sim_backend.kernel import kernel
from sim_backend.kernel.rates import rates
from sim_backend.memory.compiled import compiled
from sim_backend.memory.layout import D_STRIDE, DIFFERENTIAL, D, H, Vector, X
from sim_backend.memory.work import SIGNAL_START, WORK
from sim_backend.physics.thermal import thermal_step
from sim_backend.plant import SimulatedRig

Array = NDArray[np.float64]
SOLVERS: dict[str, type] = {"LSODA": LSODA, "BDF": BDF, "Radau": Radau}
_NO_STEP_S = 1e-12  # for the two laws that soften within a step: as good as none


@compiled
def _rates(y: Vector, p: Vector, w: Vector, d: Vector) -> None:
    kernel.start_air(y, p, w)
    rates(y, p, w, 0.0, _NO_STEP_S, d)


@dataclass(slots=True)
class Solved:
    """One rig integrated by a solver, period after period with the commands held; heat and valve commands as in the kernel."""

    sim: SimulatedRig
    solver: str
    rtol: float
    calls: int = 0
    _work: Array = field(default_factory=lambda: np.zeros(WORK))

    def run(self, commands_V: Array, period_s: float) -> dict[str, Array]:
        """True signals at the start of every period, from the state `sim` is in; `calls` counts evaluations of the rates."""
        sim, p, x = self.sim, self.sim.parameters.values, self.sim.state.copy()
        out = np.empty((len(commands_V), self._work.size))
        for row, (first, second) in enumerate(commands_V):
            kernel.hold_terms(x, p, self._work)
            kernel.evaluate(x, p, self._work, np.zeros(DIFFERENTIAL), _NO_STEP_S)
            out[row] = self._work
            kernel.start_period(x, first, second)
            kernel.start_step(x, p, self._work, 0.0, 1.0, period_s)
            x[:DIFFERENTIAL] = self._period(x[:DIFFERENTIAL].copy(), p, period_s)
            taken = x[D.SUPPLY_VOLUME] + x[D_STRIDE + D.SUPPLY_VOLUME]
            thermal_step(x, (taken - x[H.OLD_SUPPLY_VOLUME]) / period_s, x[X.SUPPLY_PRESSURE], p, period_s)
            x[H.OLD_SUPPLY_VOLUME] = taken
        return {name: out[:, SIGNAL_START + sim.parameters.signal(name)] for name in sim.signal_names()}

    def _period(self, y: Array, p: Array, period_s: float) -> Array:
        scale = np.maximum(np.abs(y), _FLOORS)
        made = SOLVERS[self.solver](self._function(p), 0.0, y, period_s, rtol=self.rtol, atol=self.rtol * scale)
        while made.status == "running":
            made.step()
        self.calls += made.nfev
        return np.asarray(made.y)

    def _function(self, p: Array) -> Callable[[float, Array], Array]:
        work = self._work

        def function(_: float, y: Array) -> Array:
            d = np.zeros(DIFFERENTIAL)
            _rates(np.ascontiguousarray(y), p, work, d)
            return d

        return function


def _floors() -> Array:
    """What counts as small of every state, in its unit: absolute tolerances are `rtol` times this where a state is smaller."""
    floors = np.full(DIFFERENTIAL, 1e-3)
    for slot in (0, D_STRIDE):
        floors[[slot + D.PRESSURE_A, slot + D.PRESSURE_B]] = 1e5
        floors[slot + D.BRISTLE] = 1e-5
        floors[[slot + D.SUPPLY_VOLUME, slot + D.LINE_FLOW, slot + D.RETURN_FLOW]] = 1e-5
    return floors


_FLOORS = _floors()
