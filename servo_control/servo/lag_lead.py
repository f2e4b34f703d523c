"""Lag-lead compensation: first-order sections (1 + s/z)/(1 + s/p) in cascade, Tustin (no prewarping), (C1) of docs/method/control.md.

    H(z) = (b0 + b1 z⁻¹)/(1 + a1 z⁻¹),   c = 2/T:   b0 = (1 + c/z)/(1 + c/p),  b1 = (1 − c/z)/(1 + c/p),  a1 = (1 − c/p)/(1 + c/p)

Anti-windup by conditioning (R. Hanus and others, Automatica 23, 1987): when a limit changes the command, the states are recomputed with
the error that would have given exactly the limited command, so the compensator always remembers what was really sent.
"""

from __future__ import annotations

from collections.abc import Sequence

Coefficients = tuple[float, float, float]


def section_coefficients(zero_rad_per_s: float, pole_rad_per_s: float, period_s: float) -> Coefficients:
    """(b0, b1, a1) of (1 + s/zero)/(1 + s/pole) by the Tustin rule at the sampling period."""
    c = 2.0 / period_s
    norm = 1.0 + c / pole_rad_per_s
    return (1.0 + c / zero_rad_per_s) / norm, (1.0 - c / zero_rad_per_s) / norm, (1.0 - c / pole_rad_per_s) / norm


class LagLead:
    """Gain and sections in cascade. `step` gives the output for one error; `condition` corrects the states after a limit acted."""

    __slots__ = ("_before", "_gain", "_sections", "_slowest", "_states")

    def __init__(self, gain: float, corners_rad_per_s: Sequence[tuple[float, float]], period_s: float) -> None:
        self._gain = gain
        self._sections = tuple(section_coefficients(zero, pole, period_s) for zero, pole in corners_rad_per_s)
        self._states = [0.0] * len(self._sections)
        self._before = [0.0] * len(self._sections)
        poles = [pole for _, pole in corners_rad_per_s]
        self._slowest = poles.index(min(poles)) if poles else -1

    def set_gain(self, gain: float) -> None:
        """The gain acts before the sections, so what they remember does not jump with it."""
        self._gain = gain

    def step(self, error: float) -> float:
        """Output for this sample (volts); advances the states by one period."""
        states, before = self._states, self._before
        x = self._gain * error
        for i, (b0, b1, a1) in enumerate(self._sections):
            state = states[i]
            before[i] = state
            y = b0 * x + state
            states[i] = b1 * x - a1 * y
            x = y
        return x

    def condition(self, error: float, excess: float) -> None:
        """Redo the last step as if the output had been larger by `excess` (negative at an upper limit)."""
        if not self._sections or self._gain == 0.0:
            return
        direct = self._gain  # what gain and sections pass on at once
        for b0, _, _ in self._sections:
            direct *= b0
        self._states[:] = self._before
        self.step(error + excess / direct)

    def preload(self, error: float, output: float) -> None:
        """Choose the states so that a constant `error` gives `output` in the next sample (bumpless start).

        Every section is put at rest for that error; what is missing to `output` is stored in the section with the slowest pole,
        where it dies out slowest, and the sections behind it are at rest for what it then gives out. A compensator without
        sections has no memory and cannot be preloaded.
        """
        x = self._gain * error
        for i, (b0, _, _) in enumerate(self._sections):
            self._states[i] = x * (1.0 - b0)
            if i == self._slowest:
                self._states[i] += output - x
                x = output

    def snapshot(self) -> list[float]:
        return list(self._states)

    def restore(self, states: Sequence[float]) -> None:
        self._states[:] = states
