"""The same block diagram without the filter hypothesis: linear loop and friction-compliance element, solved exactly
(docs/method/tuning.md, Limit cycles).

In each phase (sliding up, sliding down, stuck) the loop is linear, so its motion is a matrix exponential; only the instants of change are
searched. `march` integrates from one instant of change to the next, as the loop would run; `periodic` solves for a symmetric cycle, stable
or not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import nan

import control
import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq, root

from tuning.arrays import Floats
from tuning.limit_cycles.describing_function import FrictionCompliance


@dataclass(frozen=True, slots=True)
class Cycle:
    """Frequency, largest input M and load amplitude M − H_c, in the unit of H_c; seconds sliding and stuck per half cycle."""

    frequency_Hz: float
    amplitude: float
    load_amplitude: float
    sliding_s: float
    stuck_s: float


class ExactLoop:
    """Unity negative feedback of the load position through `loop` (strictly proper, no dead time) to the element's input."""

    def __init__(self, loop: control.TransferFunction, element: FrictionCompliance) -> None:
        self.element = element
        system = control.ss(loop)
        a, b, self._c = system.A, system.B[:, 0], system.C[0]
        order = system.nstates
        self._stuck = np.zeros((order + 1, order + 1))  # last state: the constant input −y
        self._stuck[:order, :order], self._stuck[:order, order] = a, b
        self._sliding = self._stuck.copy()  # sliding up: the input is −(c z − H_c), last state: H_c
        self._sliding[:order, :order] -= np.outer(b, self._c)
        self._order = order

    def periodic(self, sliding_s: float, stuck_s: float) -> Cycle | None:
        """The symmetric cycle near these times of half a cycle; None when there is none near."""
        solution = root(lambda v: self.mismatch(*np.exp(v)), np.log([sliding_s, stuck_s]), tol=1e-13)
        if np.max(np.abs(solution.fun)) > 1e-9:
            return None
        times = np.exp(solution.x)
        return self._cycle(float(times[0]), float(times[1]))

    def _half(self, sliding_s: float, stuck_s: float) -> tuple[Floats, Floats]:
        """States at the end of sliding and of the following rest of a half cycle after which the state is its own negative."""
        n, h = self._order, self.element.coulomb
        slide, rest = expm(self._sliding * sliding_s), expm(self._stuck * stuck_s)
        p, g = slide[:n, :n], slide[:n, n] * h
        back, drive = rest[:n, :n] - np.outer(rest[:n, n], self._c), rest[:n, n] * h
        start = np.linalg.solve(np.eye(n) + back @ p, -(back @ g) - drive)
        turned = p @ start + g
        return turned, -start

    def mismatch(self, sliding_s: float, stuck_s: float) -> tuple[float, float]:
        """Both 0 for a cycle: input speed at the end of sliding, and input travel during rest less H_s + H_c."""
        turned, end = self._half(sliding_s, stuck_s)
        n, e = self._order, self.element
        speed = self._c @ (self._sliding[:n, :n] @ turned + self._sliding[:n, n] * e.coulomb)
        return float(speed) * sliding_s, float(self._c @ (turned - end)) - e.stiction - e.coulomb

    def _cycle(self, sliding_s: float, stuck_s: float) -> Cycle:
        amplitude = float(self._c @ self._half(sliding_s, stuck_s)[0])
        return Cycle(0.5 / (sliding_s + stuck_s), amplitude, amplitude - self.element.coulomb, sliding_s, stuck_s)

    def march(self, start: float, half_cycles: int = 400, longest_s: float = 60.0, tolerance: float = 1e-5) -> Cycle | None:
        """Let go with the load held `start` away (in H_c) and the loop at rest; None when the motion dies out.

        Stops when two half cycles agree within `tolerance`. Raises no error for a loop that grows without bound: returns None then too.
        """
        z, load, sign = np.zeros(self._order), start, -1.0
        before = (0.0, 0.0)
        for _ in range(half_cycles):
            z, stuck_s = self._rest(z, load, sign, longest_s)
            if stuck_s >= longest_s:
                return None
            z, sliding_s = self._slide(z, sign, longest_s)
            load = float(self._c @ z) - sign * self.element.coulomb
            if sliding_s >= longest_s or abs(load) < 1e-3 * self.element.coulomb or abs(load) > 1e4 * self.element.coulomb:
                return None
            if abs(sliding_s - before[0]) + abs(stuck_s - before[1]) < tolerance * (sliding_s + stuck_s):
                return self.periodic(sliding_s, stuck_s) or self._cycle(sliding_s, stuck_s)
            before, sign = (sliding_s, stuck_s), -sign
        return None

    def _rest(self, z: Floats, load: float, sign: float, longest_s: float) -> tuple[Floats, float]:
        """From rest at `load` until the spring force reaches sign · H_s."""
        state = np.append(z, -load)
        return self._until(self._stuck, state, lambda v: sign * (float(self._c @ v[:-1]) - load) - self.element.stiction, longest_s)

    def _slide(self, z: Floats, sign: float, longest_s: float) -> tuple[Floats, float]:
        """Sliding until the input turns."""
        state = np.append(z, sign * self.element.coulomb)
        return self._until(self._sliding, state, lambda v: -sign * float(self._c @ (self._sliding[:-1] @ v)), longest_s)

    def _until(self, matrix: Floats, state: Floats, event: Callable[[Floats], float], longest_s: float) -> tuple[Floats, float]:
        """Follow the linear motion until `event` rises through 0; the instant is found to rounding."""
        step_s = 0.1 / max(float(np.abs(np.linalg.eigvals(matrix)).max()), 1.0)
        one, t = expm(matrix * step_s), 0.0
        while t < longest_s:
            after = one @ state
            if event(after) >= 0.0:
                part = _instant(matrix, state, event, step_s)
                return (expm(matrix * part) @ state)[:-1], t + part
            state, t = after, t + step_s
        return state[:-1], longest_s


def _instant(matrix: Floats, state: Floats, event: Callable[[Floats], float], longest_s: float) -> float:
    """When `event` becomes 0 on the way from `state`; 0 when it is over already."""
    if event(state) >= 0.0:
        return 0.0
    return float(brentq(lambda t: event(expm(matrix * t) @ state), 0.0, longest_s, xtol=1e-16))


def gain_for_frequency(loop: control.TransferFunction, element: FrictionCompliance, frequency_Hz: float, gain: float) -> float:
    """The gain factor near `gain` at which an exact cycle has this frequency; nan when none is found."""
    half_s = 0.5 / frequency_Hz

    def equations(v: Floats) -> tuple[float, float]:
        share = 1.0 / (1.0 + np.exp(-v[1]))
        return ExactLoop(float(np.exp(v[0])) * loop, element).mismatch(share * half_s, (1.0 - share) * half_s)

    found = []
    for share in (0.1, 0.2, 0.3, 0.4, 0.5):
        solution = root(equations, [np.log(gain), np.log(share / (1.0 - share))], tol=1e-12)
        if np.max(np.abs(solution.fun)) < 1e-8 and abs(solution.x[0] - np.log(gain)) < 0.7:
            found.append(float(np.exp(solution.x[0])))
    return min(found, default=nan)
