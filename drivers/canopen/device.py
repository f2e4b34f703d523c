"""What all CANopen devices share: their place on the bus, set-up, NMT state, emergencies, and how old their last frame is."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import NoReturn

from config.errors import DriverError
from config.options.canopen_options import CanopenOptions
from config.options.device_options import RigNames
from drivers.canopen.bus import HEARTBEAT_ID, OPERATIONAL, CanopenBus, Steps, acquire, release
from drivers.canopen.counts import BUS_COUNTS, DEVICE_COUNTS, counts_of
from drivers.canopen.frame_count import FrameCount
from drivers.canopen.node_setup import U16, NodeSetup, Setting
from drivers.contract import Quality, Sample

EMERGENCY_ID = 0x080
_BOOT_UP = 0
_COMMUNICATION_ERRORS = (0x81, 0x82)  # classes of EMCY codes: we were silent, or spoke wrongly
_START_LIMIT_S = 0.4  # added to three heartbeats: a reset waits for it in the loop, and the unit's watchdog allows 1 s
STALE_NS = 2_000_000  # two cycles at 1 kHz: a frame that answers the last SYNC is younger


class CanopenDevice:
    """Base of the drivers. A subclass says what is written (`_set_up`), which frame it listens to, and what a frame means.

    `received` counts its frames, `late` and `lost` those that did not come when they were due (see frame_count), `stale` the cycles with
    values older than 2 ms (times `every_syncs`), `malformed` its frames that could not be read, `heard_ns` the arrival of the last one.
    `emergency` is the code of the last EMCY (0: none, or over).
    """

    tpdo = 1  # number of the process data frame it sends
    every_syncs = 1  # and how often

    def __init__(self, name: str, options: CanopenOptions, heartbeat_period_s: float, lockstep: bool) -> None:
        if lockstep:
            raise DriverError("a CAN device lives in real time", where=f"devices.{name}", next_step="Use the wall clock, or driver: sim.")
        self.name = name
        self.inputs = tuple(options.input_channels(RigNames()))
        self.outputs = tuple(options.output_channels(RigNames()))
        self.node = options.node
        self._options = options
        self._heartbeat_period_s = heartbeat_period_s
        self._bus: CanopenBus | None = None
        self._samples = [Sample() for _ in self.inputs]
        self._configured = False
        self._came = 0  # frames of this cycle
        self._read_ns = -1
        self._values_ns = 0  # when the process data came that the samples show
        self._silence = options.missing_frames * self.every_syncs
        self._frames = FrameCount(self.every_syncs, options.missing_frames)
        self.received = self.stale = self.malformed = self.emergency = self.heard_ns = 0
        self.nmt_state = -1
        self.setup_lost = ""
        self._missed_us = False  # it reacts to our silence, as it was set up to

    def open(self) -> None:
        if self._bus is not None:
            raise DriverError("the device is open already", where=self.name)
        bus = acquire(self._options.bus, self._heartbeat_period_s)
        try:
            bus.route(self._tpdo_id, self._on_process_data)
            bus.route(HEARTBEAT_ID + self.node, self._on_heartbeat)
            bus.route(EMERGENCY_ID + self.node, self._on_emergency)
        except DriverError:
            release(bus)
            raise
        self._bus = bus

    def configure(self) -> None:
        """Write every setting, read it back and compare; then start the node and wait for the heartbeat that confirms it."""
        bus = self._opened()
        self._configured = False
        with NodeSetup(bus.can_bus, self.node, self.name) as setup:
            setup.pre_operational()
            setup.write([Setting(0x1017, 0, round(1e3 * self._options.heartbeat_s), U16, "heartbeat producer in ms")])
            self._set_up(setup)
            setup.command("OPERATIONAL", 3 * self._options.heartbeat_s + _START_LIMIT_S)
        self.nmt_state = OPERATIONAL
        self.setup_lost = ""
        self._missed_us = False
        self.emergency = 0
        self._frames.restart()
        self._configured = True

    def read(self, now_ns: int) -> Sequence[Sample]:
        self._opened().begin_cycle(now_ns)
        if now_ns != self._read_ns:
            self._read_ns = now_ns
            self._count_frame(now_ns)
            self._assess()
        if self.setup_lost:
            self._refuse_to_go_on()
        return self._samples

    def close(self) -> None:
        bus, self._bus = self._bus, None
        self._configured = False
        if bus is None:
            return
        for cob_id in (self._tpdo_id, HEARTBEAT_ID + self.node, EMERGENCY_ID + self.node):
            bus.unroute(cob_id)
        release(bus)

    @property
    def needs_setup(self) -> bool:
        """Also when it has left OPERATIONAL because of our silence: then its proof still counts."""
        return bool(self.setup_lost) or not self._configured or self.nmt_state != OPERATIONAL

    def counts(self) -> dict[str, float]:
        """DEVICE_COUNTS since the device was made."""
        return counts_of(self, DEVICE_COUNTS)

    def link_counts(self) -> tuple[str, dict[str, float]]:
        """The bus's channel, and its BUS_COUNTS since it was opened."""
        bus = self._opened()
        return bus.settings.channel, counts_of(bus, BUS_COUNTS)

    def _set_up(self, setup: NodeSetup) -> None:
        """For subclasses: write and read back what this device needs."""
        raise NotImplementedError

    def _on_process_data(self, data: bytearray, stamp_ns: int) -> None:
        """For subclasses: what a frame says; call _accept() when it could be read."""
        raise NotImplementedError

    def _assess(self) -> None:
        """For subclasses: once a cycle, the quality of the samples."""
        raise NotImplementedError

    def _accept(self, stamp_ns: int) -> None:
        self.received += 1
        self.heard_ns = self._values_ns = stamp_ns
        self._came += 1

    def _count_frame(self, now_ns: int) -> None:
        self.stale += now_ns - self._values_ns > STALE_NS * self.every_syncs
        self._frames.cycle(self._came)
        self._came = 0

    def _answers(self, done: Callable[[], bool], limit_s: float, send_command: Callable[[], None]) -> Steps[bool]:
        """Tell the device something until a frame makes `done()` true, but not the one frame that may answer an earlier SYNC."""
        self._opened().receive_waiting()
        first = self.received + 2
        end = time.monotonic_ns() + round(1e9 * limit_s)
        while not (self.received >= first and done()):
            if time.monotonic_ns() > end:
                return False
            send_command()
            yield
        return True

    def _frame_quality(self) -> Quality:
        """From the arrival of frames alone: one missing frame may be late, several mean a silent device."""
        if self._is_silent or not self.received:
            return Quality.BAD
        return Quality.GOOD if self._frames.missing < self.every_syncs else Quality.UNCERTAIN

    def _on_heartbeat(self, data: bytearray, stamp_ns: int) -> None:
        if len(data) != 1:
            self.malformed += 1
            return
        self.heard_ns = stamp_ns
        self.nmt_state = data[0] & 0x7F
        if self.nmt_state == OPERATIONAL:
            self._missed_us = False
        elif self.nmt_state == _BOOT_UP:
            self._lose_setup("restarted by itself and has lost its settings")
        elif self._reacts_to_us:
            self._missed_us = True
        else:
            self._lose_setup(f"left OPERATIONAL by itself (NMT state {self.nmt_state})")

    def _on_emergency(self, data: bytearray, stamp_ns: int) -> None:
        if len(data) != 8:
            self.malformed += 1
            return
        self.heard_ns = stamp_ns
        self.emergency = data[0] | data[1] << 8
        self._missed_us |= data[1] in _COMMUNICATION_ERRORS

    def _lose_setup(self, what: str) -> None:
        """The first reason counts: what follows is its consequence."""
        if self._configured and not self.setup_lost:
            self.setup_lost = what

    def _refuse_to_go_on(self) -> NoReturn:
        raise self._error(f"the device {self.setup_lost}", next_step=self._way_back)

    @property
    def _way_back(self) -> str:
        return "Find out why; then `longreach reset` sets it up again."

    @property
    def _reacts_to_us(self) -> bool:
        return self._missed_us or self._opened().heartbeat_withheld

    @property
    def late(self) -> int:
        return self._frames.late

    @property
    def lost(self) -> int:
        return self._frames.lost

    @property
    def _is_silent(self) -> bool:
        return self._frames.missing >= self._silence

    @property
    def _tpdo_id(self) -> int:
        return 0x80 + 0x100 * self.tpdo + self.node

    def _opened(self) -> CanopenBus:
        if self._bus is None:
            raise DriverError("the device is not open", where=self.name, next_step="Call open() first.")
        return self._bus

    def _error(self, what: str, value: object = "", limit: object = "", unit: str = "", next_step: str = "") -> DriverError:
        emergency = f" (last emergency 0x{self.emergency:04X})" if self.emergency else ""
        return DriverError(
            f"node {self.node}: {what}{emergency}", value=value, limit=limit, unit=unit, where=self.name, next_step=next_step
        )
