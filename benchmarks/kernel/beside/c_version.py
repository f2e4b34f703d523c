"""The testbed in C (plant.c), compiled for this processor and called through ctypes."""

from __future__ import annotations

import ctypes
import math
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sim_backend.memory.layout import D_STRIDE, J_START, J_STRIDE, S_START, S_STRIDE, C, D, H, J, S, X
from sim_backend.plant import SimulatedRig

Array = NDArray[np.float64]
FLAGS = ("-O3", "-march=native", "-shared", "-fPIC")
_JOINT = (
    *(J.LOW, J.HIGH, J.STOP_STIFFNESS, J.STOP_LOSS, J.AREA_A, J.AREA_B, J.VOLUME_A, J.VOLUME_B, J.VOLUME_POSITION, J.FLOW_COEFFICIENT),
    *(J.FULL_SCALE, J.SLEW_RATE, J.ROUNDING, J.LAMINAR_PRESSURE, J.VALVE_TIME, J.VALVE_DAMPING, J.HYSTERESIS, J.SATURATION),
    *(J.NULL_ADJUSTMENT, J.CROSS_LEAKAGE, J.BULK_SLOPE, J.HOSE_SLOPE, J.AIR_FRACTION, J.HOSE_COMPLIANCE, J.COULOMB, J.COULOMB_SLOPE),
    *(J.STICTION, J.STRIBECK, J.VISCOUS, J.VISCOUS_OIL_SHARE, J.BRISTLE_STIFFNESS, J.BRISTLE_DAMPING, J.BRISTLE_FADE),
)
_RIG = (
    *(C.BENDING_STIFFNESS, C.LINK_DAMPING, C.HUB_OFFSET, C.HUB_INERTIA, C.MASS_PER_LENGTH, C.TUBE_LENGTH, C.CARRIAGE, C.PAYLOAD),
    *(C.SUPPLY_PRESSURE, C.RETURN_PRESSURE, C.BULK_MODULUS, C.BULK_PRESSURE_SLOPE, C.VAPOUR_PRESSURE, C.WALTHER_A, C.WALTHER_B),
    *(C.DENSITY, C.AMBIENT, C.RESERVOIR_CAPACITY, C.RESERVOIR_LOSS, C.HOSE_CAPACITY, C.HOSE_INSIDE, C.HOSE_OUTSIDE, C.METAL_CAPACITY),
    *(C.METAL_INSIDE, C.METAL_OUTSIDE, C.METAL_SHARE, C.THERMAL_PUMP_FLOW, C.BYPASS_SHARE, C.PUMP_LOSS),
)
_STATES = (D.POSITION, D.VELOCITY, D.SPOOL, D.SPOOL_RATE, D.PRESSURE_A, D.PRESSURE_B, D.BRISTLE, D.SUPPLY_VOLUME)
_STORES = (H.RESERVOIR, H.HOSE, H.METAL, H.LINE_END, H.RETURN_OIL, H.OIL)
_MOST_SENSORS = 16
COLUMNS = (
    *("rotary.position", "prismatic.position", "rotary.pressure_a", "rotary.pressure_b", "prismatic.pressure_a", "prismatic.pressure_b"),
    *("tip.deflection", "tip.acceleration"),
)


class _Rig(ctypes.Structure):
    _fields_ = (
        ("numbers", ctypes.c_double * (2 * len(_JOINT) + len(_RIG))),
        ("sensors", ctypes.c_int),
        ("noise", ctypes.c_double * _MOST_SENSORS),
        ("keep", ctypes.c_double * _MOST_SENSORS),
        ("signal", ctypes.c_int * _MOST_SENSORS),
    )


class CPlant:
    """The shipped testbed from the present state of `sim`. Raises FileNotFoundError where there is no C compiler."""

    def __init__(self, sim: SimulatedRig, period_s: float) -> None:
        compiler = shutil.which("cc") or shutil.which("gcc")
        if compiler is None:
            raise FileNotFoundError("no C compiler (cc or gcc): the line of the C version is left out")
        self._folder = tempfile.TemporaryDirectory()
        library = Path(self._folder.name) / "plant.so"
        source = Path(__file__).parent / "plant.c"
        subprocess.run([compiler, *FLAGS, "-o", str(library), str(source), "-lm"], check=True)
        self._run = ctypes.CDLL(str(library)).run
        self._rig, self._sim, self._period_s = _filled(sim, period_s), sim, period_s

    def run(self, commands_V: Array, step_s: float) -> dict[str, Array]:
        """As SimulatedRig.run, from the state that `sim` is in: the signals of COLUMNS at the start of every period."""
        x = self._sim.state
        y = np.concatenate(
            [x[list(_STATES)], x[[D_STRIDE + i for i in _STATES]], x[[X.SHAPE_1, X.SHAPE_2, X.SHAPE_1_RATE, X.SHAPE_2_RATE]]]
        )
        play, stores, out = x[H.PLAY : H.PLAY + 2].copy(), x[list(_STORES)].copy(), np.empty((len(commands_V), len(COLUMNS)))
        given = np.ascontiguousarray(commands_V)
        arrays = [array.ctypes.data_as(ctypes.c_void_p) for array in (y, play, stores, given)]
        period, step = ctypes.c_double(self._period_s), ctypes.c_double(step_s)
        self._run(ctypes.byref(self._rig), *arrays, len(given), period, step, out.ctypes.data_as(ctypes.c_void_p))
        return dict(zip(COLUMNS, out.T, strict=True))


def _filled(sim: SimulatedRig, period_s: float) -> _Rig:
    p, rig = sim.parameters.values, _Rig()
    joints = [[float(p[J_START + slot * J_STRIDE + index]) for index in _JOINT] for slot in (0, 1)]
    for joint in joints:
        joint[_JOINT.index(J.VALVE_TIME)] **= -1  # the C version wants 1/s
    common = [float(p[index]) for index in _RIG]
    common[_RIG.index(C.DENSITY)] *= float(p[C.SPECIFIC_HEAT])  # J/m³/K
    for i, value in enumerate([*joints[0], *joints[1], *common]):
        rig.numbers[i] = value
    rig.sensors = int(p[C.SENSORS])
    for number in range(rig.sensors):
        q = S_START + number * S_STRIDE
        rig.noise[number], rig.signal[number] = p[q + S.NOISE], int(p[q + S.SIGNAL])
        rig.keep[number] = math.exp(-2 * math.pi * p[q + S.BANDWIDTH] * period_s) if p[q + S.BANDWIDTH] > 0 else 0.0
    return rig
