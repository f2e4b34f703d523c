"""One recording of the hidden machine: hide what is to be hidden, run the servo, write a CSV with the log contract's column names."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from config.schema.rig import Rig
from config.whole_file import replaced_when_done
from tests.blind.truth.effects import ADDED, EFFECTS, RATED_FLOW, STANDARD_GRAVITY, STRANGE
from tests.blind.truth.friction import SLIP
from tests.blind.truth.measure import CHANNELS, Array, Sensors, Servo, run
from tests.blind.truth.nominal import Numbers, jittered, machine, nominal
from tests.blind.truth.plant import SIGNALS, at_rest
from tests.blind.truth.references import CENTRE, reference

PERIOD_S = 0.001
JITTER = 0.01  # of the period, standard deviation of the cycle's start
SETTLE_S = 1.5  # before the log begins
UNITS = {"pressure": "_Pa", "acceleration": "_mps2", "deflection": "_m"}


@dataclass(frozen=True, slots=True)
class Hidden:
    """One hidden effect: `value` is its first parameter (an effect of the contract) or its size in plain ones (a strange effect)."""

    effect: str
    where: str
    value: float


@dataclass(frozen=True, slots=True)
class Setting:
    """Everything that decides a recording besides its maneuver."""

    seed: int
    hidden: tuple[Hidden, ...] = ()
    jitter: bool = True
    friction_form: float = SLIP
    chambers: bool = False  # chamber pressures are logged


def numbers_of(rig: Rig, setting: Setting) -> Numbers:
    """The hidden machine's numbers: wrong constants, then the hidden effects."""
    as_stated = nominal(rig)
    numbers = jittered(as_stated, setting.seed) if setting.jitter else dict(as_stated)
    numbers["friction_form"] = setting.friction_form
    for item in setting.hidden:
        if item.effect in STRANGE:
            _put_strange(numbers, item)
        elif item.effect == RATED_FLOW:
            _put_rated_flow(rig, as_stated, numbers, item)
        elif not item.where.startswith("sensor:"):
            _put(numbers, item)
    return numbers


def _put_rated_flow(rig: Rig, as_stated: Numbers, numbers: Numbers, item: Hidden) -> None:
    """A valve whose orifices are worn or clogged, as its rated flow tells."""
    assert rig.plant is not None
    valve = rig.plant.joints[item.where].valve  # type: ignore[union-attr]
    numbers[f"{item.where}.flow"] = as_stated[f"{item.where}.flow"] * item.value / valve.rated_flow_m3_per_s


def _put(numbers: Numbers, item: Hidden) -> None:
    key = next(iter(EFFECTS[item.effect].values())).format(where=item.where)
    value = STANDARD_GRAVITY * np.sin(item.value) if item.effect == "gravity" else item.value
    numbers[key] = numbers[key] + value if item.effect in ADDED else value


def _put_strange(numbers: Numbers, item: Hidden) -> None:
    for place, size in STRANGE[item.effect].items():
        key = place.format(where=item.where)
        rates = key in ("bracket_rate",) or key.endswith(".pitch")
        numbers[key] = size if rates else numbers[key] * (1.0 + size) if size < 0 else size * item.value
    numbers["payload"] -= numbers["bracket_mass"]
    numbers["carriage"] += numbers["bracket_mass"]


def sensors_of(rig: Rig, setting: Setting, draw: np.random.Generator) -> Sensors:
    """The rig's sensors with wrong lags and biases, coloured noise, and the hidden sensor effects."""
    assert rig.plant is not None
    declared = [_declared(rig, name) for name in CHANNELS]
    off = 0.2 if setting.jitter else 0.0
    table = {
        field: np.array([getattr(d, field, 0.0) for d in declared]) for field in ("bandwidth_Hz", "noise", "low", "high", "resolution")
    }
    count = len(CHANNELS)
    table["bandwidth_Hz"] *= 1 + off * draw.uniform(-1, 1, count)
    table["noise"] *= 1 + off * draw.uniform(-1, 1, count)
    table["offset"] = np.array([d.bias for d in declared]) * (1 + off * draw.uniform(-1, 1, count))
    lagged_noise = np.where(table["bandwidth_Hz"] > 0, np.exp(-2 * np.pi * table["bandwidth_Hz"] * PERIOD_S), 0.0)
    table["noise_memory"] = np.maximum(lagged_noise, draw.uniform(0.0, 0.6, count))
    table |= {"polarity": np.ones(count), "scale": np.ones(count), "delay_s": np.zeros(count), "step": np.zeros(count)}
    for item in setting.hidden:
        if item.where.startswith("sensor:"):
            field = next(iter(EFFECTS[item.effect].values()))
            k = CHANNELS.index(item.where.removeprefix("sensor:"))
            table[field][k] = table[field][k] + item.value if item.effect in ADDED else item.value
    return Sensors(**{name: np.ascontiguousarray(table[name]) for name in Sensors._fields})


def _declared(rig: Rig, name: str) -> object:
    """The rig file's sensor; chamber pressures are of the kind of the supply pressures."""
    assert rig.plant is not None
    like = name.replace("pressure_a", "supply_pressure").replace("pressure_b", "supply_pressure")
    return rig.plant.sensors[like]


def servo_of(rig: Rig, draw: np.random.Generator) -> Servo:
    """Half to nine tenths of the rig file's proportional gains, so that a hidden effect does not make the loop oscillate."""
    joints = [rig.servo[name] for name in ("rotary", "prismatic")]
    gain = np.array([j.gain for j in joints]) * draw.uniform(0.5, 0.9)
    feedforward = np.array([j.velocity_feedforward for j in joints])
    return Servo(gain, feedforward, np.array([rig.joints[name].command_limit_V for name in ("rotary", "prismatic")]))


def temperatures(rows: int, draw: np.random.Generator, jitter: bool) -> Array:
    """Oil at the valves: some kelvin off 40 °C, and drifting by up to 2 K over the log."""
    if not jitter:
        return np.full(rows, 40.0)
    share = np.linspace(0, 1, rows)
    return 40.0 + draw.uniform(-4, 4) + draw.uniform(-2, 2) * share + 0.2 * np.sin(2 * np.pi * (share + draw.uniform()))


def record(rig: Rig, setting: Setting, maneuver: str, duration_s: float, take: int, path: Path) -> None:
    """Run one maneuver (kinds joined by +) and write the log. `take` draws noise and references anew on the same machine."""
    draw = np.random.default_rng([setting.seed, 7919, take])
    m = machine(numbers_of(rig, setting))
    sensors = sensors_of(rig, setting, np.random.default_rng([setting.seed, 104729]))
    servo = servo_of(rig, np.random.default_rng([setting.seed, 1299709]))
    kinds = maneuver.split("+")
    parts = [reference(kind, int(draw.integers(2**31)), duration_s / len(kinds), PERIOD_S) for kind in kinds]
    settle = round(SETTLE_S / PERIOD_S)
    stand = np.tile([CENTRE[0], 0.0, CENTRE[1], 0.0], (settle, 1))
    asked = np.concatenate([stand, *parts])
    rows = len(asked)
    starts = PERIOD_S * np.arange(rows + 1) + JITTER * PERIOD_S * draw.standard_normal(rows + 1)
    oil = temperatures(rows, draw, setting.jitter)
    readings, commands = np.zeros((rows, SIGNALS)), np.zeros((rows, 2))
    y, play = at_rest(m, CENTRE), np.array([m.rotary.null, m.prismatic.null])
    run(y, play, asked, np.diff(starts), oil, draw.standard_normal((rows, SIGNALS)), m, sensors, servo, readings, commands)
    keep = slice(settle, rows)
    write_log(path, setting, starts[:-1][keep] - starts[settle], readings[keep], commands[keep], asked[keep], oil[keep])


def write_log(path: Path, setting: Setting, t: Array, readings: Array, commands: Array, asked: Array, oil: Array) -> None:
    """One CSV with the column names of the log contract; chamber pressures only where the setting has them."""
    columns = {"t_s": t, "rotary.command_V": commands[:, 0], "prismatic.command_V": commands[:, 1]}
    for k, name in enumerate(CHANNELS):
        if setting.chambers or not name.endswith(("pressure_a", "pressure_b")):
            columns[name + next((unit for word, unit in UNITS.items() if word in name), "")] = readings[:, k]
    for n, name in enumerate(("rotary", "prismatic")):
        columns[f"{name}.reference"], columns[f"{name}.reference_rate"] = asked[:, 2 * n], asked[:, 2 * n + 1]
    thermometer = 0.5 + (np.random.default_rng([setting.seed, 15485863]).uniform(-0.7, 0.7) if setting.jitter else 0.0)
    columns["reservoir_temperature_C"] = np.round((oil + thermometer) / 0.1) * 0.1
    with replaced_when_done(path) as part:
        np.savetxt(part, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="", fmt="%.10g")
