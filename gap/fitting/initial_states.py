"""What is not known at a window's start is integrated out.

With J₀ the sensitivity to the window's initial state s₀ and S₀ its prior covariance, a residual e is replaced by e − J₀ ŝ and the residual
of the prior, ŝ = (J₀ᵀJ₀ + S₀⁻¹)⁻¹ J₀ᵀ e. All of this is linear in e, so it acts on columns of a Jacobian alike.

So is how a seal yields before it slides. A bristle is one of many forms of that; a real seal remembers its turns and never yields twice
alike. The bristle's deflection at the start, and its stiffness, damping and excess within a window, may therefore differ from window to
window. What takes the same form in all windows stays with the constants, and friction that slides is not touched.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from gap.data.measured import Array
from gap.data.windows import SHAPE_RATE_SD, Experiment
from gap.fitting.simulate import kept, warmed
from sim_backend.kernel.batch import restart
from sim_backend.memory.layout import D_STRIDE, J_START, J_STRIDE, SLOTS, C, D, H, J, Kind, Vector, X

# Standard deviation of each state at a window's start. Positions and velocities come from the measurement; pressures, friction and
# modes are the model's own, disturbed by that correction.
_POSITION_SD, _PRESSURE_SD, _SHAPE_SD = 5e-5, 1e4, 1e-3
_MOVE = (
    0.1  # of it by which a state (or form) is moved for its sensitivity: a whole one can lead across a reversal, and is no derivative there
)
_OIL_SD_K = 1.0  # oil at the valves: a reservoir's thermometer does not follow it
_LEAST_UNPRESSED = 0.1  # of a joint's force, what its seals do not take
_BRISTLE_SD = 0.3  # of the deflection at which it slides
# Relative standard deviations, from window to window, of what stands for the form of friction before it slides.
_FORM_SD = {J.BRISTLE_STIFFNESS: 0.5, J.BRISTLE_DAMPING: 1.0, J.BRISTLE_FADE: 0.5, J.STICTION: 0.3, J.STRIBECK: 0.3}


@dataclass(frozen=True, slots=True)
class StartState:
    """One marginalised state: its number in the kernel's state vector and its prior standard deviation."""

    number: int
    sd: float


@dataclass(frozen=True, slots=True)
class FormOfFriction:
    """One marginalised number of the kernel's parameter vector and its relative standard deviation from window to window."""

    number: int
    sd: float

    def changed(self, p: Vector) -> Vector:
        other = p.copy()
        other[self.number] *= 1.0 + _MOVE * self.sd
        return other


@dataclass(frozen=True, slots=True)
class Projection:
    """What marginalising the initial states does to a residual; sensitivities in units of the prior, windows × values × states."""

    sensitivity: Array
    gain: Array  # windows × states × values

    def apply(self, e: Array) -> Array:
        """windows × values → windows × (values + states): what is left, then the cost of the initial states."""
        moved = np.matmul(self.gain, e[:, :, None])
        left = e - np.matmul(self.sensitivity, moved)[:, :, 0]
        return np.concatenate([left, moved[:, :, 0]], axis=1)

    def apply_all(self, columns: Array) -> Array:
        """numbers × windows × values → numbers × windows × (values + states)."""
        e = columns.transpose(1, 2, 0)
        moved = np.matmul(self.gain, e)
        return np.concatenate([e - np.matmul(self.sensitivity, moved), moved], axis=1).transpose(2, 0, 1)


def marginalised_readings(experiment: Experiment, p: Vector, more: Sequence[StartState] = ()) -> tuple[Array, Projection]:
    """Readings with the parameters `p` (windows × samples × channels), and the projection linearised there; `more`: states beside those of
    start_states that no window knows."""
    p = warmed(experiment, p)
    base, first = kept(experiment, p)
    states = [*start_states(p, experiment), *more]
    with ThreadPoolExecutor(experiment.workers) as pool:
        moved = list(pool.map(lambda s: restart(first, p, experiment.plan, s.number, _MOVE * s.sd), states))
        moved += pool.map(lambda form: restart(first, form.changed(p), experiment.plan, 0, 0.0), forms_of_friction(p))
    there = np.isfinite(experiment.measured)
    columns = [np.where(there, ((m - base)[:, :, experiment.columns]) / (_MOVE * experiment.sigma), 0.0) for m in moved]
    values = experiment.measured[0].size
    blank = np.empty((experiment.windows, values, 0))
    a = np.stack([np.nan_to_num(column).reshape(experiment.windows, -1) for column in columns], axis=2) if columns else blank
    return base[:, :, experiment.columns], Projection(a, _gain(a))


def _gain(a: Array) -> Array:
    return np.asarray(np.linalg.solve(np.einsum("wnk,wnl->wkl", a, a) + np.eye(a.shape[2]), a.transpose(0, 2, 1)))


def start_states(p: Vector, experiment: Experiment) -> list[StartState]:
    """Which initial states are marginalised: motion of every joint, its pressures and friction, the oil's temperature, and the link's
    shapes when it bends."""
    states = []
    for slot in range(SLOTS):
        kind = p[J_START + slot * J_STRIDE + J.KIND]
        if kind in (Kind.UNUSED, Kind.IMPOSED):
            continue
        s = slot * D_STRIDE
        states += [StartState(s + D.POSITION, _POSITION_SD), StartState(s + D.VELOCITY, experiment.velocity_sd[slot])]
        if kind == Kind.HYDRAULIC:
            states += [StartState(s + D.PRESSURE_A, _PRESSURE_SD), StartState(s + D.PRESSURE_B, _PRESSURE_SD)]
            states += bristle_start(p, slot)
    if any(p[J_START + slot * J_STRIDE + J.KIND] == Kind.HYDRAULIC for slot in range(SLOTS)):
        states.append(StartState(int(H.METAL), _OIL_SD_K))
    if p[C.ARM] > 0.0 and p[C.BENDING_STIFFNESS] > 0.0:
        states += [StartState(int(k), _SHAPE_SD) for k in (X.SHAPE_1, X.SHAPE_2)]
        states += [StartState(int(k), SHAPE_RATE_SD) for k in (X.SHAPE_1_RATE, X.SHAPE_2_RATE)]
    return states


def bristle_start(p: Vector, slot: int) -> list[StartState]:
    """How far the friction of a joint is drawn at a window's start; none without dry friction."""
    return [StartState(slot * D_STRIDE + D.BRISTLE, _BRISTLE_SD * deflection) for deflection in _sliding(p, slot)]


def forms_of_friction(p: Vector) -> list[FormOfFriction]:
    """Of every hydraulic joint with dry friction."""
    return [
        FormOfFriction(J_START + slot * J_STRIDE + number, sd)
        for slot in range(SLOTS)
        if p[J_START + slot * J_STRIDE + J.KIND] == Kind.HYDRAULIC and _sliding(p, slot)
        for number, sd in _FORM_SD.items()
    ]


def _sliding(p: Vector, slot: int) -> list[float]:
    """The bristle's deflection at which the joint breaks away; empty without dry friction."""
    at = J_START + slot * J_STRIDE
    level = breaking_away(p, at)
    return [level / float(p[at + J.BRISTLE_STIFFNESS])] if level > 0.0 else []


def breaking_away(p: Vector, at: int) -> float:
    """The most that a joint's friction holds where nothing else loads it. Pressure that moves it presses its seals: g = C + S + ½ |ΔC| +
    μ |Δp|, and A |Δp| = g."""
    level = p[at + J.COULOMB] + p[at + J.STICTION] + 0.5 * abs(p[at + J.COULOMB_DIFFERENCE])
    pressed = p[at + J.PRESSURE_FRICTION] / p[at + J.AREA_A] if p[at + J.KIND] == Kind.HYDRAULIC else 0.0
    return float(level / max(1.0 - pressed, _LEAST_UNPRESSED))
