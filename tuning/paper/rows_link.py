"""Rows 13 to 16: the flexible prismatic link (Figure 8, Eqs 6 to 13)."""

from __future__ import annotations

from math import cos, cosh, pi, sin, sinh, sqrt

import numpy as np
from scipy.optimize import brentq

from config.schema.rig import Rig
from sim_backend.kernel import kernel
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.layout import D_STRIDE, DIFFERENTIAL, SLOTS, C, D, J, Kind, X
from sim_backend.memory.work import WORK
from sim_backend.physics.energy import mechanical_energy
from sim_backend.physics.link import first_frequency, highest_frequency
from sim_backend.plant import SimulatedRig
from tuning.arrays import Floats
from tuning.paper.newton import largest_disagreement
from tuning.paper.row import ClaimRow, near

INCH_M, POUND_KG = 0.0254, 0.45359237
EXTENSIONS_IN = (12, 18, 24, 30, 36, 42, 48, 54, 60)
PAYLOADS_LB = (0, 15, 45, 75)


def exact_frequencies(extension_m: float, payload_kg: float, bending_N_m2: float, mass_per_length: float) -> tuple[float, float]:
    """First two frequencies (Hz) of a clamped beam with a tip mass: 1 + cos β cosh β + μβ (cos β sinh β − sin β cosh β) = 0."""
    ratio = payload_kg / (mass_per_length * extension_m)

    def equation(b: float) -> float:
        return 1.0 + cos(b) * cosh(b) + ratio * b * (cos(b) * sinh(b) - sin(b) * cosh(b))

    grid = np.linspace(0.05, 8.0, 1600)
    values = [equation(float(b)) for b in grid]
    roots = [float(brentq(equation, grid[i], grid[i + 1], xtol=1e-14)) for i in range(len(grid) - 1) if values[i] * values[i + 1] < 0.0]
    scale = sqrt(bending_N_m2 / mass_per_length) / (2.0 * pi * extension_m**2)
    return roots[0] ** 2 * scale, roots[1] ** 2 * scale


def map_of_frequencies(rig: Rig) -> Floats:
    """Array payload × extension × (plant f₁, plant f₂, exact f₁, exact f₂), Hz: the data behind Figure 8."""
    p = Parameters(rig).values
    table = np.empty((len(PAYLOADS_LB), len(EXTENSIONS_IN), 4))
    for i, pounds in enumerate(PAYLOADS_LB):
        p[C.PAYLOAD] = pounds * POUND_KG
        for j, inches in enumerate(EXTENSIONS_IN):
            length = inches * INCH_M
            own = first_frequency(length, p) / (2.0 * pi), highest_frequency(length, p) / (2.0 * pi)
            table[i, j] = (*own, *exact_frequencies(length, p[C.PAYLOAD], p[C.BENDING_STIFFNESS], p[C.MASS_PER_LENGTH]))
    return table


def frequencies(rig: Rig) -> ClaimRow:
    table = map_of_frequencies(rig)
    first = np.abs(table[:, :, 0] / table[:, :, 2] - 1.0).max(axis=1)
    second = np.abs(table[:, :, 1] / table[:, :, 3] - 1.0).max()
    beam = near(
        table[:, (0, 3, 8), 2].ravel().tolist(),
        (225.15, 36.023, 9.006, 36.961, 9.172, 3.145, 21.528, 5.410, 1.892, 16.705, 4.209, 1.478),
        relative=5e-4,
    )
    ok = first.max() <= 1e-3 and second <= 0.03 and beam
    return ClaimRow(
        13,
        "Fig 8: frequency over extension and payload",
        f"two shapes: f₁ off {100 * first[0]:.3f} % unloaded, {100 * first[1:].max():.4f} % loaded, f₂ {100 * second:.1f} %",
        "beam equation, which must give the published map",
        "f₁ 0.1 %, f₂ 3 %",
        bool(ok),
    )


def ratio_of_frequencies(rig: Rig) -> ClaimRow:
    row = map_of_frequencies(rig)[PAYLOADS_LB.index(45), :, 0]
    ratio = float(row[0] / row[-1])
    return ClaimRow(
        14,
        "natural frequency varies by a magnitude",
        f"45 lb: f(12 in)/f(60 in) = {ratio:.2f}",
        "11.38",
        "0.5 %",
        near([ratio], [11.38], relative=5e-3),
    )


def energy(rig: Rig) -> ClaimRow:
    """The drift of the energy in 5 s of free motion."""
    plant = _free_arm(rig)
    x, p = plant.state, plant.parameters.values
    work, scratch = np.zeros(WORK), (np.zeros(DIFFERENTIAL), np.zeros(DIFFERENTIAL), np.zeros(DIFFERENTIAL))
    start = mechanical_energy(x, p)
    worst = 0.0
    for _ in range(500):
        kernel.advance(x, p, work, scratch, 0.0, 0.0, 0.01)
        worst = max(worst, abs(mechanical_energy(x, p) / start - 1.0))
    found = f"drift {worst:.1e} over 5 s, extension 0.60 → {float(x[D_STRIDE + D.POSITION]):.2f} m"
    return ClaimRow(15, "Eqs 6–13, corrected: energy", found, "0", "1e-6 relative", worst <= 1e-6)


def _free_arm(rig: Rig) -> SimulatedRig:
    """No actuators, friction or structural damping; the tube slides out while the arm turns and vibrates."""
    plant = SimulatedRig(rig)
    p = plant.parameters.values
    for slot in range(SLOTS):
        at = plant.parameters.offset(J.KIND, plant.joints[slot]) - J.KIND
        p[at : at + len(J)] = 0.0
        p[at + J.KIND], p[at + J.FULL_SCALE], p[at + J.SLEW_RATE], p[at + J.SATURATION] = Kind.FORCE, 1.0, 1e9, 1.0
        p[at + J.LOW], p[at + J.HIGH] = -1e9, 1e9
    p[C.LINK_DAMPING], p[C.THERMAL], p[C.STEP] = 0.0, 0.0, 1e-4
    x = plant.state
    x[D.POSITION], x[D.VELOCITY], x[D_STRIDE + D.POSITION], x[D_STRIDE + D.VELOCITY] = 0.0, 0.3, 0.6, 0.02
    x[X.SHAPE_1], x[X.SHAPE_1_RATE] = 0.005, 0.02
    return plant


def newton_against_lagrange(rig: Rig) -> ClaimRow:
    worst = largest_disagreement(Parameters(rig).values)
    return ClaimRow(
        16, "Eqs 6–13, corrected: Newton against Lagrange", f"generalised forces differ by {worst:.1e}", "0", "1e-8 relative", worst <= 1e-8
    )
