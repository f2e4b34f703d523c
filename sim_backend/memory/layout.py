"""Where everything stands in the two flat vectors of the kernel: parameters and state. The enum members are the only indices.

One vector of float64 each, so that an effect is a few entries with neutral values and a state can be copied or marginalised as it is.
Two joint slots: 0 turns (rotary), 1 slides (linear). A single axis uses the slot of its motion.
"""

from __future__ import annotations

from enum import IntEnum
from functools import cache
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:  # the files of effects read this one, and every rig reads those: no numpy
    import numpy as np
    from numpy.typing import NDArray

Vector: TypeAlias = "NDArray[np.float64]"  # one-dimensional

SLOTS = 2
RING = 1024  # control periods a command or a sensor can be delayed: the longest delay allowed (0.1 s) at the highest rate (10 kHz)
MAX_SENSORS = 19


class C(IntEnum):
    """Parameters of the whole plant."""

    STEP = 0
    ARM = 1  # 1: rotary and prismatic joint coupled by the link; 0: independent axes
    BENDING_STIFFNESS = 2  # 0: rigid link
    LINK_DAMPING = 3
    HUB_OFFSET = 4
    HUB_INERTIA = 5
    MASS_PER_LENGTH = 6
    TUBE_LENGTH = 7
    CARRIAGE = 8
    PAYLOAD = 9
    PAYLOAD_INERTIA = 10
    GRAVITY = 11  # g sin(tilt), m/s²
    SUPPLY_PRESSURE = 12
    RETURN_PRESSURE = 13
    INVERSE_GAS_VOLUME = 14
    PUMP_FLOW = 15
    PUMP_BAND = 16
    PUMP_LAG = 17
    RELIEF_PRESSURE = 18
    RELIEF_GAIN = 19
    LINE_RESISTANCE = 20
    RETURN_RESISTANCE = 21
    DENSITY = 22
    SPECIFIC_HEAT = 23
    BULK_MODULUS = 24
    BULK_PRESSURE_SLOPE = 25
    VAPOUR_PRESSURE = 26  # gauge
    WALTHER_A = 27
    WALTHER_B = 28
    INITIAL_TEMPERATURE = 29
    THERMAL = 30  # 0: constant temperature
    AMBIENT = 31
    RESERVOIR_CAPACITY = 32
    RESERVOIR_LOSS = 33
    HOSE_CAPACITY = 34
    HOSE_INSIDE = 35
    HOSE_OUTSIDE = 36
    METAL_CAPACITY = 37
    METAL_INSIDE = 38
    METAL_OUTSIDE = 39
    METAL_SHARE = 40
    THERMAL_PUMP_FLOW = 41
    BYPASS_SHARE = 42
    PUMP_LOSS = 43
    SENSORS = 44  # number of sensors fitted


class Kind(IntEnum):
    """What drives a joint slot: the values of J.KIND."""

    UNUSED = 0
    HYDRAULIC = 1
    FORCE = 2  # a force actuator
    IMPOSED = 3  # moved from outside, as measured


class J(IntEnum):
    """Parameters of one joint slot; force and length stand for torque and angle in slot 0."""

    KIND = 0  # one of Kind
    LOW = 1
    HIGH = 2
    STOP_STIFFNESS = 3
    STOP_LOSS = 4
    INITIAL = 5
    MASS = 6  # of a single axis
    EXTRA_MASS = 7
    AREA_A = 8
    AREA_B = 9
    VOLUME_A = 10  # at VOLUME_POSITION
    VOLUME_B = 11
    VOLUME_POSITION = 12
    FLOW_COEFFICIENT = 13
    FULL_SCALE = 14
    SLEW_RATE = 15
    ROUNDING = 16
    LAMINAR_PRESSURE = 17
    VALVE_TIME = 18  # 0: the spool follows at once
    VALVE_DAMPING = 19
    OVERLAP = 20
    HYSTERESIS = 21
    NULL_BIAS = 22
    NULL_DRIFT = 23
    SATURATION = 24
    FLOW_ASYMMETRY = 25
    DELAY = 26
    CROSS_LEAKAGE = 27
    EXTERNAL_LEAKAGE = 28
    BULK_SLOPE = 29
    HOSE_SLOPE = 30
    AIR_FRACTION = 31
    HOSE_COMPLIANCE = 32
    FORCE_GAIN = 33  # force at full scale
    COULOMB = 34
    COULOMB_SLOPE = 35
    STICTION = 36
    STRIBECK = 37
    VISCOUS = 38
    VISCOUS_OIL_SHARE = 39
    COULOMB_DIFFERENCE = 40
    VISCOUS_DIFFERENCE = 41
    PRESSURE_FRICTION = 42
    BRISTLE_STIFFNESS = 43
    BRISTLE_DAMPING = 44
    BRISTLE_FADE = 45
    GAP = 46  # 0: rigid drive train
    DRIVE_STIFFNESS = 47
    DRIVE_DAMPING = 48
    ACTUATOR_MASS = 49
    SENSOR_ON_ACTUATOR = 50
    UNBALANCE = 51
    NULL_ADJUSTMENT = 52  # mechanical, by hand: no effect, and added to NULL_BIAS
    TABLE_KNOTS = 53  # of a force without a name, 2 to 8; 0: there is none
    TABLE_INPUT = 54  # 1: velocity, 2: position, 3: command, 4: pressure difference
    TABLE_AT_0 = 55  # knots, increasing
    TABLE_AT_1 = 56
    TABLE_AT_2 = 57
    TABLE_AT_3 = 58
    TABLE_AT_4 = 59
    TABLE_AT_5 = 60
    TABLE_AT_6 = 61
    TABLE_AT_7 = 62
    TABLE_FORCE_0 = 63
    TABLE_FORCE_1 = 64
    TABLE_FORCE_2 = 65
    TABLE_FORCE_3 = 66
    TABLE_FORCE_4 = 67
    TABLE_FORCE_5 = 68
    TABLE_FORCE_6 = 69
    TABLE_FORCE_7 = 70
    TABLE_RUBS = 71  # 1: the table adds to the friction while sliding
    BRISTLE_ELASTIC = 72  # share of its level up to which a contact does not slip; 0: LuGre. No rig file sets it


class S(IntEnum):
    """Parameters of one sensor."""

    SIGNAL = 0  # index of the true signal (see Signal)
    RESOLUTION = 1
    NOISE = 2
    BANDWIDTH = 3
    BIAS = 4
    LOW = 5
    HIGH = 6
    DROPOUT = 7
    DELAY = 8
    SCALE = 9
    OFFSET = 10
    POLARITY = 11
    QUANTUM = 12


class D(IntEnum):
    """Differential states of one joint slot."""

    POSITION = 0
    VELOCITY = 1
    SPOOL = 2
    SPOOL_RATE = 3
    PRESSURE_A = 4
    PRESSURE_B = 5
    BRISTLE = 6
    ACTUATOR_POSITION = 7  # with backlash; else unused
    ACTUATOR_VELOCITY = 8
    LINE_FLOW = 9  # flow in the supply hose, lagged by its inertia
    RETURN_FLOW = 10
    SUPPLY_VOLUME = 11  # oil taken from the supply since the start


class X(IntEnum):
    """Differential states of the whole plant, after those of the two slots."""

    SHAPE_1 = 24
    SHAPE_2 = 25
    SHAPE_1_RATE = 26
    SHAPE_2_RATE = 27
    SUPPLY_PRESSURE = 28
    GAS_RATIO = 29  # accumulator gas volume over its volume at the start
    PUMP_FLOW = 30


class H(IntEnum):
    """States that change by jumps: once a step or once a control period."""

    TIME = 32
    SEED = 33
    SAMPLE = 34  # samples sensed so far: the counter of the noise
    RESERVOIR = 35  # temperatures, degC
    HOSE = 36
    METAL = 37
    LINE_END = 38
    RETURN_OIL = 39
    OIL = 40  # temperature that sets viscosity and bulk modulus
    OLD_SUPPLY_VOLUME = 41
    RING_HEAD = 42
    FROZEN = 43  # 1: positions stand still while the rest settles
    SENSE_PERIOD = 46  # for which the sensors' lags have been set
    PLAY = 44  # two entries: spool command after hysteresis, one a slot


class TrueSignal(IntEnum):
    """True values a sensor can measure, in the order of the signal vector."""

    POSITION = 0
    SUPPLY_PRESSURE = 2
    RETURN_PRESSURE = 4
    SUPPLY_TEMPERATURE = 6
    RETURN_TEMPERATURE = 8
    PRESSURE_A = 10
    PRESSURE_B = 12
    TIP_ACCELERATION = 14
    TIP_DEFLECTION = 15
    RESERVOIR_TEMPERATURE = 16
    SECOND_POSITION = 17


class Target(IntEnum):
    """Columns of the measured motion of a window plan: one column a slot where the name is a joint's, else one."""

    POSITION = 0  # two columns
    VELOCITY = 2  # two
    TIP_DEFLECTION = 4
    TIP_DEFLECTION_RATE = 5
    ACCELERATION = 6  # two; for joints whose motion is imposed


SIGNALS = 19
TARGETS = 8  # columns
C_END = len(C)
J_STRIDE = len(J)
S_STRIDE = len(S)
J_START = C_END
S_START = J_START + SLOTS * J_STRIDE
PARAMETERS = S_START + MAX_SENSORS * S_STRIDE

D_STRIDE = len(D)
DIFFERENTIAL = 32
RING_START = 48
SENSOR_START = RING_START + SLOTS * RING
SENSOR_STRIDE = RING + 3  # lagged value, coloured noise, what the lag keeps of it in a period, then the ring
STATES = SENSOR_START + MAX_SENSORS * SENSOR_STRIDE


@cache
def parameter_names() -> tuple[str, ...]:
    """A name for every entry of the parameter vector: `payload`, `slot0.coulomb`, `sensor3.noise`."""
    common = [item.name.lower() for item in C]
    joints = [f"slot{slot}.{item.name.lower()}" for slot in range(SLOTS) for item in J]
    sensors = [f"sensor{number}.{item.name.lower()}" for number in range(MAX_SENSORS) for item in S]
    return (*common, *joints, *sensors)
