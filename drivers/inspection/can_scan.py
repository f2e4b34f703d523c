"""Which CANopen nodes are on a bus: heard first, then asked for their device type (0x1000) and identity (0x1018).

Safe on a bus that is wired to a machine: SDO reads alone. No NMT command, no SYNC, no heartbeat of ours, no write. Where a master
speaks already, nothing is sent at all.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import can

from config.errors import DriverError
from config.options.canopen_options import CanBus
from drivers.canopen.bus import open_can
from drivers.canopen.node_reader import NodeReader
from drivers.canopen.node_setup import U32
from drivers.canopen.sdo_upload import upload_request
from drivers.inspection.can_traffic import Traffic, listen
from drivers.link_claim import LinkClaim, holder, named

_PAUSE_S = 0.002  # between two requests: a frame at 125 kbit/s takes 1 ms, and a small transmit queue must not fill
_ANSWERS_S = 0.3
_MESSAGE = "SDO"
# Profile (CiA number) → the driver that speaks to such a device.
DRIVERS = {401: "canopen_io_401", 406: "canopen_encoder_406", 408: "canopen_valve_408"}


@dataclass(frozen=True, slots=True)
class Identity:
    """Objects 0x1000, 0x1018 and 0x1008; None or empty where the node does not have them."""

    device_type: int
    vendor: int | None
    product: int | None
    revision: int | None
    serial: int | None
    name: str

    @property
    def profile(self) -> int:
        """The number of the CiA profile; 0: none."""
        return self.device_type & 0xFFFF

    @property
    def driver(self) -> str:
        return DRIVERS.get(self.profile, "")


@dataclass(frozen=True, slots=True)
class FoundNode:
    """`heard`: what it sent by itself. No identity: it did not answer, or was not asked."""

    node: int
    heard: tuple[str, ...]
    identity: Identity | None


@dataclass(frozen=True, slots=True)
class BusScan:
    """What one bus showed at one bit rate. `passive`: why nothing was sent; empty when nodes were asked."""

    bus: CanBus
    frames: int
    error_frames: int
    passive: str
    nodes: tuple[FoundNode, ...]


def scan_bus(bus: CanBus, nodes: Sequence[int], listen_s: float, only_listen: bool, progress: Callable[[str], None]) -> BusScan:
    """Listen, and ask unless a master speaks there. DriverError when the bus cannot be opened."""
    claimed = holder(bus.link)
    claim = None if only_listen or claimed is not None else LinkClaim(bus.link)
    can_bus = None
    try:
        can_bus = open_can(bus)
        traffic = Traffic()
        progress(f"{bus.channel}: listening for {listen_s:g} s")
        listen(can_bus, traffic, listen_s)
        passive = _why_passive(traffic, claimed, only_listen)
        frames = traffic.frames  # some interfaces give us our own requests back
        if not passive:
            progress(f"{bus.channel}: asking for object 0x1000")
            _ask(can_bus, traffic, nodes)
        found = tuple(_found(can_bus, node, traffic.nodes[node], not passive) for node in sorted(traffic.nodes) if node)
        return BusScan(bus, frames, traffic.error_frames, passive, found)
    finally:
        if can_bus is not None:
            can_bus.shutdown()
        if claim is not None:
            claim.release()


def scan_rates(
    bus: CanBus, rates: Sequence[float], nodes: Sequence[int], listen_s: float, only_listen: bool, progress: Callable[[str], None]
) -> list[BusScan]:
    """Every bit rate is listened at before anything is sent at any: a frame at a wrong rate disturbs the others.

    Where frames are heard at one rate, nodes are asked at this one alone.
    """
    buses = [bus.model_copy(update={"bitrate": rate}) for rate in rates]
    if len(buses) == 1:
        return [scan_bus(buses[0], nodes, listen_s, only_listen, progress)]
    heard = [scan_bus(each, nodes, listen_s, True, progress) for each in buses]
    right = [scan for scan in heard if scan.frames]
    if only_listen:
        return heard
    quiet = [scan for scan in heard if not scan.error_frames]
    return [scan_bus(scan.bus, nodes, listen_s, False, progress) for scan in right or quiet]


def _why_passive(traffic: Traffic, claimed: int | None, only_listen: bool) -> str:
    if claimed is not None:
        return f"{named(claimed)} of longreach speaks on this bus"
    if traffic.masters:
        return f"a master speaks on this bus ({', '.join(sorted(traffic.masters))})"
    if traffic.error_frames and not traffic.frames:
        return "there are only error frames: the bit rate is another one, or the wiring is wrong"
    return "as asked" if only_listen else ""


def _ask(bus: can.BusABC, traffic: Traffic, nodes: Sequence[int]) -> None:
    for node in nodes:
        try:
            bus.send(upload_request(node, 0x1000, 0), 0.1)
        except (can.CanError, OSError) as error:
            advice = "Is another device on the bus, at this bit rate, and are both terminators in place? `ip -details link show` tells."
            raise DriverError("a request cannot be sent", value=str(error), where=f"node {node}", next_step=advice) from error
        listen(bus, traffic, _PAUSE_S)
    listen(bus, traffic, _ANSWERS_S)


def _found(bus: can.BusABC, node: int, heard: list[str], asked: bool) -> FoundNode:
    by_itself = tuple(what for what in heard if what != _MESSAGE)
    return FoundNode(node, by_itself, identity(bus, node) if asked and _MESSAGE in heard else None)


def identity(bus: can.BusABC, node: int) -> Identity | None:
    """Asked of one node; None when it does not answer."""
    with NodeReader(bus, node, f"node {node}") as reader:
        try:
            device_type = reader.read(0x1000, 0, U32)
        except DriverError:
            return None
        vendor, product, revision, serial = (_number(reader, sub) for sub in range(1, 5))
        return Identity(device_type, vendor, product, revision, serial, _text(reader))


def _number(reader: NodeReader, sub: int) -> int | None:
    with contextlib.suppress(DriverError):
        return reader.read(0x1018, sub, U32)
    return None


def _text(reader: NodeReader) -> str:
    with contextlib.suppress(DriverError):
        return reader.upload(0x1008, 0).split(b"\0")[0].decode("ascii", "replace").strip()
    return ""
