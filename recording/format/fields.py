"""What one row of the log holds: names, units and meaning of every field of the cycle record.

These names are a stable interface (log files, CSV columns, reports). A name carries its unit as suffix where the unit is fixed;
positions and rates are in rad for rotary joints and m for linear ones. Fields are in the order in which they are stored.
"""

from __future__ import annotations

from dataclasses import dataclass

from config.signal_names import SECOND_POSITION


@dataclass(frozen=True, slots=True)
class Field:
    """One number of the record. `ros_type` is a fixed-size primitive of the ROS 2 interface language; NaN means not fitted."""

    name: str
    ros_type: str
    unit: str
    description: str


CYCLE_FIELDS = (
    Field("cycle", "uint64", "", "executed cycles since the loop started, contiguous"),
    Field("t_s", "float64", "s", "deadline of this cycle since the loop started; jumps where periods were skipped"),
    Field("mode", "uint8", "", "0 disarmed, 1 arming, 2 holding, 3 running, 4 stopping, 5 fault, 6 proving"),
    Field("maneuver", "uint32", "", "number n of the run (attachments run-n.json, maneuver-n.yaml); 0 none"),
    Field("segment", "uint32", "", "segment of the run's plan, 1 the first; 0 outside runs"),
    Field("late_us", "float64", "us", "start of the cycle after its deadline"),
    Field("read_us", "float64", "us", "time spent reading the devices"),
    Field("compute_us", "float64", "us", "time spent in checks, trajectory and servo"),
    Field("write_us", "float64", "us", "time spent writing the devices"),
    Field("overruns", "uint32", "", "cycles that ended late since the loop started"),
    Field("drops", "uint32", "", "records that did not reach the log since the loop started"),
)

_JOINT_FIELDS = (
    ("target", "Q", "planned position before shaping"),
    ("target_rate", "Q/s", "planned rate before shaping"),
    ("reference", "Q", "position asked of the servo, after shaping"),
    ("reference_rate", "Q/s", "rate asked of the servo, after shaping"),
    ("position", "Q", "measured position; rotary 0 at mid stroke, anticlockwise positive; linear: extension"),
    ("velocity", "Q/s", "rate estimated from the measured position"),
    ("command_V", "V", "command to the valve or drive, held until the next row"),
    ("supply_pressure_Pa", "Pa", "gauge pressure at the valve's supply port"),
    ("return_pressure_Pa", "Pa", "gauge pressure at the valve's return port"),
    ("supply_temperature_C", "degC", "oil temperature at the supply port"),
    ("return_temperature_C", "degC", "oil temperature at the return port"),
    ("pressure_a_Pa", "Pa", "gauge pressure in chamber A (optional sensor)"),
    ("pressure_b_Pa", "Pa", "gauge pressure in chamber B (optional sensor)"),
)
_SECOND_FIELDS = ((SECOND_POSITION, "Q", "position as another sensor of the same motion reads it; a field only where it is fitted"),)
_TIP_FIELDS = (
    ("acceleration_mps2", "m/s^2", "transverse acceleration at the tip"),
    ("deflection_m", "m", "transverse deflection of the tip, positive towards growing rotary angle"),
    ("correction_rad", "rad", "added to the error of the rotary servo by the end-point feedback"),
)
_RIG_FIELDS = (("reservoir_temperature_C", "degC", "oil temperature in the reservoir"),)

# signal (key of the rig file's `signals:`, without its joint) -> field that stores its engineering value
_JOINT_SIGNALS = {
    "position": "position",
    "supply_pressure": "supply_pressure_Pa",
    "return_pressure": "return_pressure_Pa",
    "supply_temperature": "supply_temperature_C",
    "return_temperature": "return_temperature_C",
    "pressure_a": "pressure_a_Pa",
    "pressure_b": "pressure_b_Pa",
}
_SECOND_SIGNALS = {SECOND_POSITION: SECOND_POSITION}
_TIP_SIGNALS = {"acceleration": "acceleration_mps2", "deflection": "deflection_m"}
_RIG_SIGNALS = {"reservoir_temperature": "reservoir_temperature_C"}

# What Controller.step computes for the tip and for a joint: the columns that re-execution compares bit for bit.
TIP_CORRECTION = "tip.correction_rad"
CONTROLLER_FIELDS = ("target", "target_rate", "reference", "reference_rate", "velocity", "command_V")
FIRST_CYCLE = "first_cycle"  # entry of the metadata `recording`: the cycle before which the controller's state in the log is


def joint_fields(joint: str, motion: str, second: bool) -> list[Field]:
    """Fields of one joint, `rotary.target` first; `motion` ("rotary" or "linear") gives the unit of positions. `second`: whether it has a
    second position sensor, whose fields come last."""
    length, prefix = "rad" if motion == "rotary" else "m", f"{joint}."
    fields = _named(prefix, _in_unit(_JOINT_FIELDS, length), _JOINT_SIGNALS)
    return fields + _named(prefix, _in_unit(_SECOND_FIELDS, length), _SECOND_SIGNALS) if second else fields


def tip_fields() -> list[Field]:
    return _named("tip.", list(_TIP_FIELDS), _TIP_SIGNALS)


def rig_fields() -> list[Field]:
    return _named("", list(_RIG_FIELDS), _RIG_SIGNALS)


def field_of_signal(signal: str) -> str:
    """Field that stores a signal's value: `rotary.supply_pressure` -> `rotary.supply_pressure_Pa`. KeyError for no signal of the log."""
    part, _, name = signal.rpartition(".")
    if not part:
        return _RIG_SIGNALS[name]
    return f"{part}.{(_TIP_SIGNALS if part == 'tip' else _JOINT_SIGNALS | _SECOND_SIGNALS)[name]}"


def signals_of(joints: tuple[str, ...]) -> tuple[str, ...]:
    """Every signal that each log of these joints holds, in the order of the fields."""
    of_joints = tuple(f"{joint}.{signal}" for joint in joints for signal in _JOINT_SIGNALS)
    return of_joints + tuple(f"tip.{signal}" for signal in _TIP_SIGNALS) + tuple(_RIG_SIGNALS)


def _in_unit(rows: tuple[tuple[str, str, str], ...], length: str) -> list[tuple[str, str, str]]:
    return [(name, unit.replace("Q", length), description) for name, unit, description in rows]


def _named(prefix: str, rows: list[tuple[str, str, str]], signals: dict[str, str]) -> list[Field]:
    fields = [Field(prefix + name, "float64", unit, description) for name, unit, description in rows]
    for signal in signals:
        fields.append(Field(f"{prefix}{signal}_raw", "float64", "counts", f"{signal} as the device gave it"))
        fields.append(Field(f"{prefix}{signal}_age_s", "float64", "s", f"age of the {signal} sample when it was used"))
    return fields
