"""The simulated rig: command volts in, raw sensor counts out, advanced period by period or many periods at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from config.errors import PlantError
from config.schema.rig import Rig
from sim_backend.kernel import kernel, servo_run
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory import compile_cache
from sim_backend.memory.layout import D_STRIDE, DIFFERENTIAL, J_START, J_STRIDE, SIGNALS, SLOTS, STATES, C, D, H, J, X
from sim_backend.memory.work import SIGNAL_START, WORK, scratch
from sim_backend.physics.sensors import raw_counts, start_sensors

_SETTLE_S = 2.0
_SETTLE_PERIOD_S = 0.01
_DEFAULT_PERIOD_S = 0.001


class SimulatedRig:
    """One simulated rig.

    `parameters.values` and `state` are the kernel's flat vectors; changing parameters acts from the next `advance` or `reset` on.
    `channels` names the sensors (keys of plant.sensors) in the order of `sense`. Same seed and commands: same result, bit for bit.
    `say` gets one line when the kernel must be compiled first (default: stderr).
    """

    def __init__(self, rig: Rig, seed: int = 0, say: Callable[[str], None] | None = None) -> None:
        compile_cache.announce(say)
        self.rig = rig
        self.parameters = Parameters(rig)
        self.joints = tuple(rig.joints)
        self.channels: tuple[str, ...] = tuple(self.parameters.sensors)
        self.state: NDArray[np.float64] = np.zeros(STATES)
        self._work: NDArray[np.float64] = np.zeros(WORK)
        self._scratch = scratch()
        self._counts: NDArray[np.float64] = np.zeros(len(self.channels))
        self._slots = tuple(self.parameters.slots[name] for name in self.joints)
        self._seed = seed
        self._period_s = _DEFAULT_PERIOD_S
        self.reset()

    def reset(self, positions: Sequence[float] | None = None, temperature_C: float | None = None) -> None:
        """Start over: joints at `positions` (rad or m, order of rig.joints; default plant.joints.*.initial), oil and metal at
        `temperature_C` (default plant.oil.initial_temperature). Pressures, friction and link are settled with the spools centred."""
        x, p = self.state, self.parameters.values
        x[:] = 0.0
        x[H.SEED] = float(self._seed)
        x[H.RESERVOIR : H.OIL + 1] = p[C.INITIAL_TEMPERATURE] if temperature_C is None else temperature_C
        x[X.SUPPLY_PRESSURE], x[X.GAS_RATIO] = p[C.SUPPLY_PRESSURE], 1.0
        for slot in range(SLOTS):
            s, j = slot * D_STRIDE, J_START + slot * J_STRIDE
            x[s + D.PRESSURE_A] = x[s + D.PRESSURE_B] = 0.5 * (p[C.SUPPLY_PRESSURE] + p[C.RETURN_PRESSURE])
            x[s + D.POSITION] = x[s + D.ACTUATOR_POSITION] = p[j + J.INITIAL]
        for slot, position in zip(self._slots, positions or (), strict=positions is not None):
            x[slot * D_STRIDE + D.POSITION] = x[slot * D_STRIDE + D.ACTUATOR_POSITION] = position
        self._settle()
        start_sensors(x, p, self._work)

    def _settle(self) -> None:
        """Let everything but the positions come to rest at command 0, without warming up and without using random numbers."""
        x, p = self.state, self.parameters.values
        thermal, p[C.THERMAL] = p[C.THERMAL], 0.0
        x[H.FROZEN] = 1.0
        for _ in range(round(_SETTLE_S / _SETTLE_PERIOD_S)):
            kernel.advance(x, p, self._work, self._scratch, 0.0, 0.0, _SETTLE_PERIOD_S)
        x[H.FROZEN] = x[H.TIME] = x[H.SAMPLE] = 0.0
        p[C.THERMAL] = thermal
        for slot in range(SLOTS):
            x[slot * D_STRIDE + D.SUPPLY_VOLUME] = 0.0
        kernel.hold_terms(x, p, self._work)
        kernel.evaluate(x, p, self._work, self._scratch[1], p[C.STEP])

    def advance(self, command_V: Sequence[float], period_s: float) -> None:
        """One control period with the commands (order of rig.joints) held."""
        commands = [0.0, 0.0]
        for slot, volts in zip(self._slots, command_V, strict=True):
            commands[slot] = volts
        self._period_s = period_s
        kernel.advance(self.state, self.parameters.values, self._work, self._scratch, commands[0], commands[1], period_s)

    def sense(self) -> list[float]:
        """Raw counts of every channel at this instant; NaN for a sample that dropped out."""
        raw_counts(self.state, self.parameters.values, self._period_s, self._counts)
        return self._counts.tolist()  # type: ignore[no-any-return]

    @property
    def true_position(self) -> list[float]:
        """Positions of the joints (load side), rad or m."""
        return [float(self.state[slot * D_STRIDE + D.POSITION]) for slot in self._slots]

    @property
    def time_s(self) -> float:
        """Simulated time since the start."""
        return float(self.state[H.TIME])

    def true_signal(self, name: str) -> float:
        """True value of one signal at this instant."""
        return float(self._work[SIGNAL_START + self.parameters.signal(name)])

    def run(self, command_V: ArrayLike, period_s: float, sense: bool = False) -> dict[str, NDArray[np.float64]]:
        """Advance by one period for every row of command_V, shape (n, joints), in one compiled call.

        Returns arrays of length n, row k being the plant at the start of period k (before command k acts): `t_s`, `J.position`,
        `J.velocity`, `J.spool` and every signal's true value by its name; with `sense` also `raw`, shape (n, channels).
        """
        given = np.asarray(command_V, dtype=np.float64)
        if given.ndim != 2 or given.shape[1] != len(self.joints):
            raise PlantError("commands must have one column a joint", value=given.shape, limit=f"(n, {len(self.joints)})")
        commands = np.zeros((len(given), SLOTS))
        commands[:, self._slots] = given
        states, signals = np.empty((len(given), DIFFERENTIAL)), np.empty((len(given), SIGNALS))
        raw = np.empty((len(given) if sense else 0, len(self.channels)))
        start_s = self.time_s
        self._period_s = period_s
        kernel.run(self.state, self.parameters.values, self._work, self._scratch, commands, period_s, states, signals, raw)
        result: dict[str, NDArray[np.float64]] = {"t_s": start_s + period_s * np.arange(len(given), dtype=np.float64)}
        for name, slot in zip(self.joints, self._slots, strict=True):
            s = slot * D_STRIDE
            result |= {f"{name}.velocity": states[:, s + D.VELOCITY], f"{name}.spool": states[:, s + D.SPOOL]}
        for name in self.signal_names():
            result[name] = signals[:, self.parameters.signal(name)]
        return result | ({"raw": raw} if sense else {})

    def follow(self, references: ArrayLike, servos: ArrayLike, period_s: float, rows: int) -> dict[str, NDArray[np.float64]]:
        """Hold the joints on references by simple servos, in one compiled call: for hours of moving whose heat is wanted.

        `references`: shape (n, 2 × joints), a row a period: positions (rad or m), then rates. `servos`: shape (joints, 3): gain (V per
        rad or m), feed-forward (V per rad/s or m/s), largest command (V). Positions are the true ones. n must be a multiple of `rows`.

        Returns arrays of length `rows`, means over their shares of the time: valve `flow` (m³/s), `reservoir_temperature`,
        `supply_temperature`, `return_temperature`, `metal_temperature` (degC).
        """
        given, gains = np.asarray(references, dtype=np.float64), np.asarray(servos, dtype=np.float64)
        joints = len(self.joints)
        if given.ndim != 2 or given.shape[1] != 2 * joints or gains.shape != (joints, 3) or rows < 1 or len(given) % rows:
            limit = f"(a multiple of {rows}, {2 * joints}) and ({joints}, 3)"
            raise PlantError("references and servos do not fit the rig", value=(given.shape, gains.shape), limit=limit)
        placed, servo = np.zeros((len(given), 2 * SLOTS)), np.zeros((SLOTS, 3))
        for joint, slot in enumerate(self._slots):
            placed[:, slot], placed[:, SLOTS + slot], servo[slot] = given[:, joint], given[:, joints + joint], gains[joint]
        self._period_s = period_s
        out = np.empty((rows, len(servo_run.COLUMNS)))
        servo_run.servo_run(self.state, self.parameters.values, self._work, self._scratch, placed, servo, period_s, out)
        return {name: out[:, column] for column, name in enumerate(servo_run.COLUMNS)}

    def signal_names(self) -> list[str]:
        """Every signal that has a true value here, fitted with a sensor or not."""
        quantities = (
            "position",
            "second_position",
            "supply_pressure",
            "return_pressure",
            "supply_temperature",
            "return_temperature",
            "pressure_a",
            "pressure_b",
        )
        own = [f"{name}.{quantity}" for name in self.joints for quantity in quantities]
        return [*own, "tip.acceleration", "tip.deflection", "reservoir_temperature"]
