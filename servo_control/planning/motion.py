"""A run under way: the place on the program's path, the controlled stop, the shaper, and when everything is at rest.

The stop slows path time down (σ from 1 to 0, ṫ_path = σ), so the arm stays on its path: with q(τ) the program,
target rate = q'σ and target acceleration = q''σ² + q'σ̇. σ̇ is chosen every cycle as low as the joints' acceleration limits allow.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Any

from servo_control.path.program import ROUNDING_S
from servo_control.path.waves import smooth_step
from servo_control.planning.run_plan import RunPlan

FASTEST_STOP_PER_S = 20.0  # σ̇ where nothing moves: excitation in volts is taken away within 50 ms
SLOWEST_STOP_PER_S = 1.0  # a stop is never longer than about a second, even at the acceleration limit
JOIN_S = 1.0  # the rest between held position and program start vanishes over this time, or longer at low rate limits
JOIN_RATE_SHARE = 0.1


class Motion:
    """Starts at rest at the held targets. `advance` gives the next cycle's target and reference."""

    __slots__ = (
        "_accelerations", "_cycles", "_flush_cycles", "_index", "_join_s", "_offset", "_period_s", "_program", "_rest_cycles", "_shaper",
        "_sigma", "_stopping", "_tau", "done", "plan", "reference", "reference_rate", "segment", "target", "target_rate", "volts",
    )  # fmt: skip

    def __init__(
        self, plan: RunPlan, held: Sequence[float], rate_limits: Sequence[float], acceleration_limits: Sequence[float], period_s: float
    ) -> None:
        self.plan = plan
        self._program = plan.program
        self._period_s = period_s
        self._accelerations = tuple(acceleration_limits)
        self._offset = [a - b for a, b in zip(held, plan.start_position, strict=True)]
        needed = max(1.875 * abs(d) / (JOIN_RATE_SHARE * rate) for d, rate in zip(self._offset, rate_limits, strict=True))
        self._join_s = max(JOIN_S, needed) if needed > 0.0 else 0.0
        self._shaper = plan.shaper.build()
        self._shaper.reset(held)
        self._flush_cycles = ceil(self._shaper.flush_s / period_s)
        self._cycles = self._rest_cycles = self._index = 0
        self._tau, self._sigma = 0.0, 1.0
        self._stopping = self.done = False
        self.target, self.reference = list(held), list(held)
        self.target_rate, self.reference_rate = [0.0] * len(held), [0.0] * len(held)
        self.volts: Sequence[float] = [0.0] * len(held)
        self.segment = 0

    def advance(self, *, stop: bool) -> None:
        """One cycle. `stop` begins the controlled stop, which is not taken back; `done` tells that all is at rest."""
        self._stopping = self._stopping or stop
        self._index = self._program.next_index(self._index, self._tau)
        positions, rates, accelerations, volts = self._program.at(self._tau, self._index)
        self._follow(positions, rates)
        self.volts = [v * self._sigma for v in volts] if self._stopping else volts
        self.segment = self._index + 1
        self._shaper.step(self.target, self.target_rate, self.reference, self.reference_rate)
        self.done = self._at_rest() and self._rest_cycles >= self._flush_cycles
        self._move_on(rates, accelerations)

    def _follow(self, positions: Sequence[float], rates: Sequence[float]) -> None:
        """Target = program + what is left of the offset at the start; counts the cycles since the target last moved."""
        sigma = self._sigma
        t = self._cycles * self._period_s
        if t < self._join_s:
            share, slope, _ = smooth_step(t, self._join_s)
            target = [p + (1.0 - share) * d for p, d in zip(positions, self._offset, strict=True)]
            self.target_rate = [r * sigma - slope * d for r, d in zip(rates, self._offset, strict=True)]
        else:
            target = list(positions)
            self.target_rate = [r * sigma for r in rates]
        self._rest_cycles = self._rest_cycles + 1 if target == self.target else 0
        self.target = target

    def _at_rest(self) -> bool:
        """The program has ended or has been stopped, and so has the joining."""
        ended = self._sigma == 0.0 or self._tau >= self._program.duration_s - ROUNDING_S
        return ended and self._cycles * self._period_s >= self._join_s

    def _move_on(self, rates: Sequence[float], accelerations: Sequence[float]) -> None:
        self._cycles += 1
        if not self._stopping:
            self._tau = self._cycles * self._period_s
            return
        before = self._sigma
        self._sigma = max(0.0, before - self._period_s * self._deceleration(rates, accelerations))
        self._tau += 0.5 * (before + self._sigma) * self._period_s

    def _deceleration(self, rates: Sequence[float], accelerations: Sequence[float]) -> float:
        """The largest −σ̇ for which |q''σ² + q'σ̇| stays within every joint's limit."""
        square = self._sigma * self._sigma
        largest = FASTEST_STOP_PER_S
        for rate, acceleration, limit in zip(rates, accelerations, self._accelerations, strict=True):
            if rate != 0.0:  # a joint moving up may be slowed to −limit, one moving down to +limit
                room = limit + (acceleration if rate > 0.0 else -acceleration) * square
                largest = min(largest, room / abs(rate))
        return max(largest, SLOWEST_STOP_PER_S)

    def snapshot(self) -> dict[str, Any]:
        """All but the plan, which its request gives again."""
        return {
            "cycles": self._cycles,
            "rest_cycles": self._rest_cycles,
            "offset": list(self._offset),
            "join_s": self._join_s,
            "tau": self._tau,
            "sigma": self._sigma,
            "stopping": self._stopping,
            "target": list(self.target),
            "shaper": self._shaper.snapshot(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """On a motion made from the same plan."""
        self._cycles, self._rest_cycles = state["cycles"], state["rest_cycles"]
        self._offset, self._join_s = list(state["offset"]), state["join_s"]
        self._tau, self._sigma, self._stopping = state["tau"], state["sigma"], state["stopping"]
        self.target = list(state["target"])
        self._index = self._program.index_at(self._tau)
        self._shaper.restore(state["shaper"])
