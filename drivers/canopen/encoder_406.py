"""Absolute encoders and linear transducers after CiA 406: position, speed and alarms in one frame at every SYNC."""

from __future__ import annotations

import struct

from config.options.canopen_options import EncoderOptions
from config.options.canopen_rig import our_heartbeat_period_s
from config.options.driver_options import device_options
from config.schema.rig import Device, Rig
from drivers.canopen.device import CanopenDevice
from drivers.canopen.node_setup import ON_SYNC, U32, NodeSetup, Setting, pdo_settings
from drivers.contract import Quality

_FRAME = struct.Struct("<IhH")  # 0x6004 position, 0x6030:1 speed, 0x6503 alarms
_MAPPING = (0x60040020, 0x60300110, 0x65030010)


def create(name: str, device: Device, rig: Rig, lockstep: bool) -> EncoderDriver:
    """The driver factory (`driver: canopen_encoder_406` in a rig file)."""
    options = device_options(name, device)
    assert isinstance(options, EncoderOptions)
    return EncoderDriver(name, options, our_heartbeat_period_s(rig, options.bus), lockstep)


class EncoderDriver(CanopenDevice):
    """Inputs `position` and `speed` in counts. An alarm bit (for example: position error, no magnet) makes both BAD."""

    def __init__(self, name: str, options: EncoderOptions, heartbeat_period_s: float, lockstep: bool) -> None:
        super().__init__(name, options, heartbeat_period_s, lockstep)
        self._resolution = options.resolution
        self._position, self._speed = self._samples
        self.alarms = 0
        self.resolution = 0
        self.operating_status = 0

    def _set_up(self, setup: NodeSetup) -> None:
        setup.write(pdo_settings(False, 1, self.node, ON_SYNC, _MAPPING))
        setup.switch_off_other_pdos([(False, 1)])
        if self._resolution is not None:
            setup.compare(Setting(0x6501, 0, self._resolution, U32, "resolution"))
        self.resolution = setup.read(0x6501, 0, U32)
        self.operating_status = setup.read(0x6500, 0, "<H")

    def activate(self) -> None:
        """Nothing to activate: an encoder has no outputs."""
        self._opened()

    def write(self, values: object, now_ns: int) -> None:
        """Nothing to write."""

    def safe(self) -> None:
        """Nothing to make safe."""

    def _on_process_data(self, data: bytearray, stamp_ns: int) -> None:
        if len(data) != _FRAME.size:
            self.malformed += 1
            return
        self._position.raw, self._speed.raw, self.alarms = _FRAME.unpack(data)
        self._position.stamp_ns = self._speed.stamp_ns = stamp_ns
        self._accept(stamp_ns)

    def _assess(self) -> None:
        quality = self._frame_quality()
        if self.alarms:
            quality = Quality.BAD
        elif self.emergency and quality is Quality.GOOD:
            quality = Quality.UNCERTAIN
        self._position.quality = self._speed.quality = quality
