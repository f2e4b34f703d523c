"""The plant between the simulated devices: spool demands and analogue outputs go in as volts, sensor values come out as device counts.

A device's count is what the rig file's calibration says: count = (value − offset) / scale. So the twin is a rig whose calibration is
right; a wrong one is found against the plant's own sensors with `check`, not here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from config.errors import PlantError
from config.schema.rig import Rig
from sim_backend.memory.layout import C, H, X
from sim_backend.plant import SimulatedRig

FAULTS = ("supply_pressure", "oil_temperature")


class _Sensor(NamedTuple):
    channel: int  # in the plant's order
    resolution: float
    offset: float
    scale: float


class PlantFeed:
    """`counts[signal]` is the latest device count of every signal of the rig that the plant has a sensor for."""

    def __init__(self, rig: Rig, plant: SimulatedRig) -> None:
        if rig.plant is None:
            raise PlantError("there is nothing to simulate", where=rig.name, next_step="Add the section plant: to the rig file.")
        self.plant = plant
        self.period_s = 1.0 / rig.loop.rate_Hz
        self.counts: dict[str, float] = {}
        self._sensors = {
            name: _Sensor(
                plant.channels.index(name), rig.plant.sensors[name].resolution, signal.calibration.offset, signal.calibration.scale
            )
            for name, signal in rig.signals.items()
            if name in plant.channels
        }
        self._healthy = plant.parameters.values.copy()
        self._cool = plant.state[H.RESERVOIR : H.OIL + 1].copy()
        self._heated = False
        self._sense()

    def step(self, command_V: Sequence[float]) -> None:
        """One period."""
        self.plant.advance(command_V, self.period_s)
        self._sense()

    def inject(self, fault: str, amount: float) -> None:
        """`supply_pressure`: pump and relief valve go to `amount` Pa; `oil_temperature`: all oil and metal is at `amount` degC."""
        if fault == "supply_pressure":
            self.plant.parameters.values[[C.SUPPLY_PRESSURE, C.RELIEF_PRESSURE]] = amount
            self._settle_ideal_supply()
        elif fault == "oil_temperature":
            self.plant.state[H.RESERVOIR : H.OIL + 1] = amount
            self._heated = True
        else:
            raise PlantError("the plant has no such fault", value=fault, limit=", ".join(FAULTS))

    def clear(self) -> None:
        """The healthy parameters, and oil as warm as at the start when it was heated."""
        self.plant.parameters.values[:] = self._healthy
        if self._heated:
            self.plant.state[H.RESERVOIR : H.OIL + 1] = self._cool
            self._heated = False
        self._settle_ideal_supply()

    def describe(self) -> dict[str, float | str]:
        positions = zip(self.plant.joints, self.plant.true_position, strict=True)
        return {"time_s": self.plant.time_s, **{f"{joint}.position": position for joint, position in positions}}

    def _settle_ideal_supply(self) -> None:
        """A supply without accumulator has its new pressure at once; its state stands still otherwise."""
        values = self.plant.parameters.values
        if values[C.INVERSE_GAS_VOLUME] == 0.0:
            self.plant.state[X.SUPPLY_PRESSURE] = values[C.SUPPLY_PRESSURE]

    def _sense(self) -> None:
        raw = self.plant.sense()
        self.counts = {
            name: (raw[sensor.channel] * sensor.resolution - sensor.offset) / sensor.scale for name, sensor in self._sensors.items()
        }
