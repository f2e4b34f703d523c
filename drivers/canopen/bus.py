"""One CAN bus shared by all its devices: drained once a cycle in the loop's thread, SYNC and our heartbeat sent by the loop itself.

Nothing here runs in a thread of its own: when the loop stops, SYNC and heartbeat stop too, and the devices make themselves safe.

A frame's stamp is its time of arrival on the monotonic clock. The interface stamps with the wall clock, which may be stepped; but a
frame that was not there when the bus was last found empty arrived since then, so the stamp is held between that instant and now.

A cycle in which a frame could not be sent (ENOBUFS: the transmit queue is full) or the controller is bus-off is a faulty cycle. A
set point that could not be sent is dropped, never sent later: the next cycle has a newer one.
"""

from __future__ import annotations

import shlex
import time
from collections.abc import Callable, Generator
from typing import Any, NoReturn, TypeVar

import can

from config.errors import DriverError
from config.options.canopen_options import CanBus
from config.options.multicast import refuse_leaking_multicast
from drivers.canopen.counts import BusState
from drivers.link_claim import LinkClaim

SYNC_ID = 0x080
HEARTBEAT_ID = 0x700
OPERATIONAL = 5
MOST_FRAMES = 128  # a cycle: six times what 1 Mbit/s carries in 1 ms; what is left over comes in the next cycle and is counted
CONVERSATION_PERIOD_NS = 1_000_000  # SYNC period outside the loop
_CONTROLLER, _BUS_OFF, _RESTARTED = 0x004, 0x040, 0x100  # classes of SocketCAN's error frames
_STATES = ((0x30, BusState.PASSIVE), (0x0C, BusState.WARNING), (0x40, BusState.ACTIVE))  # byte 1 of class CONTROLLER
_UNREADABLE = can.Message(is_error_frame=True)  # counts as an error frame that says nothing

FrameHandler = Callable[[bytearray, int], None]  # data, time of arrival in ns
T = TypeVar("T")
Steps = Generator[None, None, T]  # what takes several cycles: one step in each, with SYNC and received frames between them


class CanopenBus:
    """The bus of a set of devices. `heartbeat_period_s` = 0: no heartbeat of ours is needed."""

    def __init__(self, can_bus: can.BusABC, settings: CanBus, heartbeat_period_s: float) -> None:
        self.can_bus = can_bus
        self.settings = settings
        self.heartbeat_period_ns = round(1e9 * heartbeat_period_s)
        self.heartbeat_sent_ns = 0
        self.heartbeat_withheld = False  # on purpose, to see what the devices do
        self._routes: dict[int, FrameHandler] = {}
        self._sync = can.Message(arbitration_id=SYNC_ID, is_extended_id=False)
        self._heartbeat = can.Message(arbitration_id=HEARTBEAT_ID + settings.own_node, is_extended_id=False, data=[OPERATIONAL])
        self._cycle_ns = -1
        self._emptied_ns = 0
        self._heartbeat_due_ns = 0
        self._cycle_faulty = False
        self._faulty_cycles = 0
        self._last_error = ""
        self.state = BusState.ACTIVE
        self.frames = self.foreign = self.left_over = self.send_failures = self.error_frames = 0

    def route(self, cob_id: int, handler: FrameHandler) -> None:
        """Frames with this identifier go to `handler`. DriverError when another device has it already."""
        if cob_id in self._routes:
            raise DriverError("two devices use one CAN identifier", value=hex(cob_id), where=self.settings.channel)
        self._routes[cob_id] = handler

    def unroute(self, cob_id: int) -> None:
        self._routes.pop(cob_id, None)

    def begin_cycle(self, now_ns: int) -> None:
        """Once a cycle (further calls with the same `now_ns` do nothing): receive what has come, then SYNC for the next answers.

        Raises DriverError when there were too many faulty cycles in a row.
        """
        if now_ns == self._cycle_ns:
            return
        self._cycle_ns = now_ns
        self._count_fault()
        self._drain(now_ns)
        self._send_heartbeat_if_due(now_ns)
        self.send(self._sync)
        if self._faulty_cycles >= self.settings.fault_cycles:
            self._raise_fault()

    def send(self, message: can.Message) -> None:
        """Send, or count that it could not be sent. Never waits, never repeats."""
        try:
            self.can_bus.send(message, 0)
        except (can.CanError, OSError) as error:
            self.send_failures += 1
            self._cycle_faulty = True
            self._last_error = str(error)

    def receive_waiting(self) -> None:
        """Handle what has come since the last cycle."""
        self._drain(time.monotonic_ns())

    def run(self, steps: Steps[T]) -> T:
        """Run the steps to their end outside the loop, one in every cycle made here: only for activation and shutdown."""
        while True:
            started = time.monotonic_ns()
            self._send_heartbeat_if_due(started)
            try:
                next(steps)
            except StopIteration as end:
                result: T = end.value
                return result
            self.send(self._sync)
            self._listen(started + CONVERSATION_PERIOD_NS)

    def shutdown(self) -> None:
        self.can_bus.shutdown()

    def _drain(self, now_ns: int) -> None:
        unix_minus_monotonic_ns = time.time_ns() - now_ns
        receive = self._receive
        for _ in range(MOST_FRAMES):
            message = receive(0.0)
            if message is None:
                if not self._cycle_faulty:
                    self._emptied_ns = now_ns
                return
            self._dispatch(message, now_ns, unix_minus_monotonic_ns)
        self.left_over += 1
        self._cycle_faulty = True
        self._last_error = f"more than {MOST_FRAMES} frames in one cycle"

    def _listen(self, until_ns: int) -> None:
        while (now := time.monotonic_ns()) < until_ns:
            message = self._receive((until_ns - now) * 1e-9)
            now = time.monotonic_ns()
            if message is not None:
                self._dispatch(message, now, time.time_ns() - now)
            elif not self._cycle_faulty:
                self._emptied_ns = now

    def _receive(self, timeout_s: float) -> can.Message | None:
        try:
            return self.can_bus.recv(timeout_s)
        except (can.CanError, OSError) as error:
            self._cycle_faulty = True
            self._last_error = str(error)
        except Exception:  # whatever an interface raises for bytes that are no frame (udp_multicast carries anything)
            return _UNREADABLE
        return None

    def _dispatch(self, message: can.Message, now_ns: int, unix_minus_monotonic_ns: int) -> None:
        if message.is_error_frame:
            self._on_error_frame(message.arbitration_id, message.data)
            return
        handler = self._routes.get(message.arbitration_id)
        if handler is None or message.is_extended_id or message.is_remote_frame:
            self.foreign += 1
            return
        self.frames += 1
        arrived = int(message.timestamp * 1e9) - unix_minus_monotonic_ns
        handler(message.data, min(max(arrived, self._emptied_ns), now_ns))

    def _on_error_frame(self, classes: int, data: bytearray) -> None:
        self.error_frames += 1
        if classes & _BUS_OFF:
            self.state = BusState.OFF
        elif classes & _RESTARTED:
            self.state = BusState.ACTIVE
        elif classes & _CONTROLLER and len(data) > 1 and self.state is not BusState.OFF:
            self.state = next((state for bits, state in _STATES if data[1] & bits), self.state)

    def _send_heartbeat_if_due(self, now_ns: int) -> None:
        if self.heartbeat_withheld or not self.heartbeat_period_ns:
            return
        if now_ns >= self._heartbeat_due_ns:
            self._heartbeat_due_ns = now_ns + self.heartbeat_period_ns
            self.heartbeat_sent_ns = now_ns
            self.send(self._heartbeat)

    def _count_fault(self) -> None:
        faulty = self._cycle_faulty or self.state is BusState.OFF
        self._faulty_cycles = self._faulty_cycles + 1 if faulty else 0
        self._cycle_faulty = False

    def _raise_fault(self) -> NoReturn:
        what = "the CAN controller is bus-off" if self.state is BusState.OFF else f"the CAN bus is faulty ({self._last_error})"
        raise DriverError(
            what,
            value=f"{self._faulty_cycles} cycles in a row",
            limit=self.settings.fault_cycles,
            where=self.settings.channel,
            next_step="Check cable, terminators, bit rate and that nothing else floods the bus.",
        )


class _Shared:
    """A bus and how many devices have it open. No other process of longreach may be its master meanwhile."""

    def __init__(self, settings: CanBus, heartbeat_period_s: float) -> None:
        self.claim = LinkClaim(settings.link)
        try:
            self.bus = CanopenBus(open_can(settings), settings, heartbeat_period_s)
        except DriverError:
            self.claim.release()
            raise
        self.users = 0

    def shutdown(self) -> None:
        self.bus.shutdown()
        self.claim.release()


_shared: dict[tuple[str, str], _Shared] = {}


def acquire(settings: CanBus, heartbeat_period_s: float) -> CanopenBus:
    """The bus of these settings, opened by its first user. DriverError when it cannot be opened or another process has it."""
    entry = _shared.get(settings.key)
    if entry is None:
        entry = _shared[settings.key] = _Shared(settings, heartbeat_period_s)
    entry.users += 1
    return entry.bus


def release(bus: CanopenBus) -> None:
    """Give the bus back; the last user closes it."""
    entry = _shared[bus.settings.key]
    entry.users -= 1
    if entry.users == 0:
        del _shared[bus.settings.key]
        entry.shutdown()


def _bring_up(settings: CanBus) -> str:
    if settings.interface != "socketcan":
        return f"Is python-can's interface {settings.interface} installed, and its device there?"
    link = shlex.quote(settings.channel)
    return f"`ip link show {link}` says whether it is up; `ip link set {link} up type can bitrate {int(settings.bitrate)}` brings it up."


def open_can(settings: CanBus) -> can.BusABC:
    """python-can's bus. DriverError when it cannot be opened, or when frames of udp_multicast would leave this machine."""
    if settings.interface == "udp_multicast":
        refuse_leaking_multicast(settings.channel)
    # The bit rate of a SocketCAN interface is set by the network configuration; python-can ignores it there.
    options: dict[str, Any] = {"interface": settings.interface, "channel": settings.channel, "bitrate": int(settings.bitrate)}
    try:
        return can.Bus(**options)
    except (can.CanError, OSError, ValueError, ImportError) as error:
        raise DriverError(
            "the CAN bus cannot be opened",
            value=f"{type(error).__name__}: {error}",
            where=f"{settings.interface} {settings.channel}",
            next_step=_bring_up(settings),
        ) from error
