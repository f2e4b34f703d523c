"""Rows 1 to 5: ratings, Eq 1, Eq 4, Eqs 2 and 3."""

from __future__ import annotations

from functools import partial
from math import sqrt

import numpy as np

from config.schema.rig import Rig
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.layout import C, J
from tuning.arrays import Complexes, Floats
from tuning.eq4 import NUMERATOR, PRODUCT_PER_S2, SUM_PER_S
from tuning.experiments.sine_test import relative_to_eq4, rotary, velocity_response
from tuning.limit_cycles.describing_function import FrictionCompliance
from tuning.linear.margins import margins
from tuning.paper.row import SWEEP_HZ, ClaimRow, figures, near
from tuning.paper.set_e import poles_and_gain, set_e
from tuning.transfer import EQ4
from tuning.variants import PRISMATIC, ROTARY


def ratings(rig: Rig) -> ClaimRow:
    p = Parameters(rig)
    supply = p.values[C.SUPPLY_PRESSURE]
    torque, force = p.values[p.offset(J.AREA_A, ROTARY)] * supply, p.values[p.offset(J.AREA_A, PRISMATIC)] * supply / 1e3
    claim = "20 000 in lbf, 6280 lbf at 2000 psi"
    return ClaimRow(
        1,
        claim,
        f"{torque:.1f} N m, {force:.3f} kN",
        "2259.7 N m, 27.95 kN",
        "0.1 %",
        near((torque, force), (2259.7, 27.95), relative=1e-3),
    )


def equation_1(rig: Rig) -> ClaimRow:
    """Set E: the numbers of Eq 4 put into oil, leakage, drag and valve of the plant, which is then linearised by differences."""
    pole, gain = poles_and_gain(set_e(rig))
    measured = (-pole.real, pole.imag, gain)
    target = (0.5 * SUM_PER_S, sqrt(PRODUCT_PER_S2 - 0.25 * SUM_PER_S**2), NUMERATOR / PRODUCT_PER_S2)
    return ClaimRow(
        2,
        "Eq 1, with K_q/A_p in the numerator",
        f"poles −{measured[0]:.6f} ± {measured[1]:.6f}j, gain {measured[2]:.6f} °/s/V",
        f"−{target[0]:.6f} ± {target[1]:.6f}j, {target[2]:.6f}",
        "1e-6 relative",
        near(measured, target, relative=1e-6),
        "set E: leak rate 10 1/s, viscous rate 130 1/s, friction off",
    )


def equation_4(rig: Rig) -> ClaimRow:
    frequencies = [f for f in SWEEP_HZ if f <= 8.0]
    gain, phase = relative_to_eq4(frequencies, velocity_response(rig, rotary(), 0.3, frequencies))
    measured = (float(np.abs(gain).max()), float(np.abs(phase).max()))
    return ClaimRow(
        3,
        "Eq 4",
        f"set R at 0.3 V, 0.5–8 Hz: within {measured[0]:.2f} dB / {measured[1]:.1f}°",
        "Eq 4",
        "0.5 dB / 3°",
        measured[0] <= 0.5 and measured[1] <= 3.0,
    )


def loop_margins(_: Rig) -> ClaimRow:
    found = [margins(partial(_scaled_eq4, k)) for k in (0.8, 1.0, 1.2)]
    crossover, phase = [m.crossover_Hz for m in found], [m.phase_margin_deg for m in found]
    gain = found[1].gain_margin_dB
    ok = near(crossover, (4.59, 5.53, 6.37), absolute=0.02) and near(phase, (52.8, 45.5, 39.0), absolute=0.2) and abs(gain - 11.07) <= 0.02
    return ClaimRow(
        4,
        "Eq 4 × {0.8, 1, 1.2} in a unity loop",
        f"f_c {figures(crossover, '.2f')} Hz, PM {figures(phase, '.1f')}°, GM {gain:.2f} dB",
        "4.59 / 5.53 / 6.37 Hz, 52.8 / 45.5 / 39.0°, 11.07 dB",
        "0.02 Hz, 0.2°, 0.02 dB",
        ok,
        "the paper's 5–6 Hz are these crossover frequencies",
    )


def _scaled_eq4(k: float, omega: Floats) -> Complexes:
    return np.asarray(k * EQ4(1j * omega))


def equations_2_3(_: Rig) -> ClaimRow:
    """The element followed by its rules, first harmonic by Fourier, against Eqs 2 and 3 as printed."""
    worst = 0.0
    for ratio in (1.0, 1.1, 1.2):
        element = FrictionCompliance.of_ratio(ratio)
        for h in (0.1, 0.3, 0.5, 0.7, 0.9):
            harmonic = element.harmonics(1.0 / h, 1, 1 << 19)[0]
            worst = max(worst, abs(complex(harmonic - element.describing_function(1.0 / h))))
    return ClaimRow(5, "Eqs 2, 3a, 3b", f"largest difference {worst:.1e}", "0", "1e-5", worst <= 1e-5, "right as printed")
