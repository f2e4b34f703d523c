"""What readings hang on beside constants and effects: every window's start, and how friction yields before it slides.

A window's initial states and its own form of friction are as in gap.fitting.initial_states, with one thing more: a start that is read off
a sensor is as uncertain as its readings. In the state's own units that is the less, the larger the sensor's scale. Else a model whose
sensor reads too small would be sure of every window's start for nothing, and gain evidence with their number. What of the form all windows
share is in gap.evidence.noise.repeated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.evidence.noise.repeated import elastic_changes, repeated_changes
from gap.fitting.initial_states import StartState, bristle_start, forms_of_friction, marginalised_readings, start_states
from sim_backend.memory.layout import D_STRIDE, J_START, J_STRIDE, S_START, S_STRIDE, SLOTS, C, D, J, Kind, S, TrueSignal, Vector, X

UNTOLD = 0.1  # of the noise, all readings of a window together: Σ is within 1 % along a mixture that is left out


@dataclass(frozen=True, slots=True)
class Unknowns:
    """Of one log, how readings change with what is integrated out, in units of the noise and of the priors, 0 where nothing was measured:
    `states` of every window by itself, `forms` alike in all windows and logs; numbers × windows × samples × channels. The last `contacts`
    of the forms are contacts that do not creep, which η does not scale."""

    states: Array
    forms: Array
    contacts: int = 0


def unknowns_of(experiments: Sequence[Experiment], p: Vector) -> tuple[Unknowns, ...]:
    """What readings of every log hang on with the parameters `p`."""
    return tuple(_of_log(e, p) for e in experiments)


def in_noise(experiment: Experiment, columns: Array) -> Array:
    """Changes of readings in units of each channel's noise, 0 where nothing was measured."""
    there = np.isfinite(experiment.measured) & np.isfinite(columns)
    return np.divide(columns, experiment.sigma, out=np.zeros(columns.shape), where=there)


def _of_log(experiment: Experiment, p: Vector) -> Unknowns:
    readings, projection = marginalised_readings(experiment, p, drawn_at_start(p))
    a = told(projection.sensitivity * start_widths(p, experiment))
    states = np.ascontiguousarray(a.transpose(2, 0, 1)).reshape(a.shape[2], *experiment.measured.shape)
    contacts = elastic_changes(experiment, p, readings)
    changes = [*repeated_changes(experiment, p, readings), *contacts]
    forms = in_noise(experiment, np.stack(changes)) if changes else np.empty((0, *readings.shape))
    return Unknowns(states, forms, len(contacts))


def told(a: Array) -> Array:
    """windows × values × numbers → the same with fewer: in every window those mixtures of the numbers that its readings tell. AAᵀ is as it
    was, up to what the noise hides. Where a simulation has run away all stay as they are."""
    inner = np.einsum("wnk,wnl->wkl", a, a)
    if not np.isfinite(inner).all():
        return a
    energy, mixtures = np.linalg.eigh(inner)
    most = int((energy > UNTOLD**2).sum(axis=1).max(initial=0))
    return np.asarray(a @ mixtures[:, :, energy.shape[1] - most :])


def start_widths(p: Vector, experiment: Experiment) -> Array:
    """Standard deviation of every unknown of a window beside the one it has where all sensors read true."""
    reads = {int(p[q + S.SIGNAL]): abs(p[q + S.SCALE]) for q in range(S_START, S_START + int(p[C.SENSORS]) * S_STRIDE, S_STRIDE)}
    measured: dict[int, int] = {int(X.SHAPE_1): TrueSignal.TIP_DEFLECTION, int(X.SHAPE_1_RATE): TrueSignal.TIP_DEFLECTION}
    for slot in range(SLOTS):
        measured |= {slot * D_STRIDE + number: TrueSignal.POSITION + slot for number in (D.POSITION, D.VELOCITY)}
    own = [1.0 / reads.get(measured.get(state.number, -1), 1.0) for state in start_states(p, experiment)]
    return np.array(own + [1.0] * (len(drawn_at_start(p)) + len(forms_of_friction(p))))


def drawn_at_start(p: Vector) -> list[StartState]:
    """Bristles of joints that a force drives: where a window begins on measured motion, what holds the joint there is not known. (Of
    hydraulic joints they are among start_states.)"""
    force = [slot for slot in range(SLOTS) if p[J_START + slot * J_STRIDE + J.KIND] == Kind.FORCE]
    return [state for slot in force for state in bristle_start(p, slot)]
