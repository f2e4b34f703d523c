"""All simulated devices of a rig on one CAN bus, fed by one plant. No clock, no thread, no socket: frames and times are handed in."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from config.errors import PlantError
from sim_backend.twin.can.can_node import CanNode
from sim_backend.twin.can.can_port import Frame
from sim_backend.twin.plant_feed import PlantFeed
from sim_backend.twin.step_clock import StepClock

NMT_ID, SYNC_ID = 0x000, 0x080
Volts = Callable[[int], float]  # once a plant period, with the time in ns: the command of one joint
Update = Callable[[Mapping[str, float]], None]  # once a plant period, with the counts of all signals


class Injectable(Protocol):
    """Whatever faults can be injected into."""

    def inject(self, fault: str, amount: float) -> None: ...

    def clear(self) -> None: ...

    def describe(self) -> dict[str, float | str]: ...


class SimulatedDevices:
    """`volts`: one function a joint, in the order of rig.joints. `updates` bring the plant's counts to the devices."""

    def __init__(self, feed: PlantFeed, nodes: list[CanNode], volts: list[Volts], updates: list[Update]) -> None:
        self.feed = feed
        self.nodes = nodes
        self.clock = StepClock(feed.period_s)
        self.syncs = self.unanswered = 0
        self._period_ns = round(1e9 * feed.period_s)
        self._volts = volts
        self._updates = updates
        self.devices: dict[str, Injectable] = {"plant": feed, **{node.name: node for node in nodes}}

    def add(self, name: str, device: Injectable, update: Update) -> None:
        """A device that is not on the bus."""
        self.devices[name] = device
        self._updates.append(update)

    def start(self, now_ns: int) -> None:
        """Power on."""
        for node in self.nodes:
            node.start(now_ns)
        self._update()

    def on_frames(self, frames: Sequence[Frame], now_ns: int) -> None:
        """What has arrived from the bus, in order.

        After this process stood still there may be many SYNCs. The plant moves by all of them, but of those that are older than a
        period only the newest is answered: a device's answer says where the arm is, and a controller that got the others in a burst
        would see an arm that leaps.
        """
        newest = max((number for number, frame in enumerate(frames) if frame.cob_id == SYNC_ID), default=0)
        for number, (cob_id, data, arrived_ns) in enumerate(frames):
            is_late = cob_id == SYNC_ID and number < newest and now_ns - arrived_ns > self._period_ns
            self.unanswered += is_late
            self.on_frame(cob_id, data, min(arrived_ns, now_ns), answer=not is_late)

    def on_frame(self, cob_id: int, data: bytes, now_ns: int, answer: bool = True) -> None:
        """A frame from the bus. At SYNC the plant moves first, so that the devices answer with the state at this instant."""
        if cob_id == SYNC_ID:
            self.syncs += 1
            self._step(self.clock.at_sync(now_ns), now_ns)
            if answer:
                for node in self.nodes:
                    node.on_sync(now_ns)
        elif cob_id == NMT_ID:
            for node in self.nodes:
                node.on_nmt(data, now_ns)
        else:
            for node in self.nodes:
                node.on_frame(cob_id, data, now_ns)

    def tick(self, now_ns: int) -> None:
        """Call about once a millisecond."""
        for node in self.nodes:
            node.tick(now_ns)
        self._step(self.clock.between(now_ns), now_ns)

    def device(self, name: str) -> Injectable:
        """The device, or "plant"; PlantError with the known names."""
        found = self.devices.get(name)
        if found is None:
            raise PlantError("the twin has no such device", value=name, limit=", ".join(self.devices))
        return found

    def describe(self) -> dict[str, dict[str, float | str]]:
        """The state of every device and of the plant."""
        return {name: device.describe() for name, device in self.devices.items()}

    def _step(self, periods: int, now_ns: int) -> None:
        for _ in range(periods):
            self.feed.step([volts(now_ns) for volts in self._volts])
        if periods:
            self._update()

    def _update(self) -> None:
        for update in self._updates:
            update(self.feed.counts)
