"""`device scan WHERE`: which nodes and units are there, and which device of the rig file each is. Nothing is written or started."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from daemon.cli.connection import add_json_option
from daemon.cli.devices.words import add_line_settings, add_where

if TYPE_CHECKING:
    from daemon.cli.devices.where import DeviceLinks
    from drivers.inspection.can_scan import BusScan, FoundNode
    from drivers.inspection.modbus_scan import FoundUnit, LinkScan

SAFE = "Reads only: no NMT command, no SYNC, no heartbeat of ours, no write. Nothing is started and nothing moves."


def options(parser: argparse.ArgumentParser) -> None:
    parser.description = f"Find CANopen nodes and Modbus units. {SAFE}"
    add_where(parser)
    add_line_settings(parser, several=True)
    parser.add_argument("--nodes", default="1-127", metavar="RANGE", help="CANopen nodes that are asked (default 1-127)")
    parser.add_argument("--units", default="1-16", metavar="RANGE", help="Modbus units that are asked (default 1-16)")
    parser.add_argument("--listen", default="1 s", metavar="TIME", help="how long a CAN bus is listened to before (default 1 s)")
    parser.add_argument("--passive", action="store_true", help="listen on CAN and ask nobody")
    add_json_option(parser)
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    from config.units import to_si
    from daemon.cli.devices.where import numbers, of_word
    from daemon.cli.shown.progress import progress_lines
    from drivers.inspection.can_scan import scan_rates
    from drivers.inspection.modbus_scan import scan_units

    where = of_word(arguments)
    nodes, units = numbers(arguments.nodes, "--nodes", 1, 127), numbers(arguments.units, "--units", 1, 247)
    listen_s, progress = to_si(arguments.listen, "s"), progress_lines(arguments.json)
    by_bus: dict[tuple[str, str], list[float]] = {}
    for bus in where.buses:
        by_bus.setdefault(bus.key, []).append(bus.bitrate)
    buses = [
        scan
        for key, rates in by_bus.items()
        for scan in scan_rates(next(bus for bus in where.buses if bus.key == key), rates, nodes, listen_s, arguments.passive, progress)
    ]
    lines = [] if arguments.passive else list(scan_units(where.lines, units, progress))
    if arguments.json:
        print(json.dumps({"buses": [_bus(scan, where) for scan in buses], "lines": [_line(scan, where) for scan in lines]}))
        return 0
    _show(where, buses, lines)
    return 0


def _show(where: DeviceLinks, buses: list[BusScan], lines: list[LinkScan]) -> None:
    from daemon.cli.shown.terminal import text_table
    from drivers.inspection.modbus_scan import place

    print(SAFE)
    for bus in buses:
        heard = f"{bus.frames} frames heard" + (f", {bus.error_frames} error frames" if bus.error_frames else "")
        why = f"; listened only: {bus.passive}" if bus.passive else ""
        print(f"\n{bus.bus.interface} {bus.bus.channel}, {_rate(bus.bus.interface, bus.bus.bitrate)}: {heard}{why}")
        silent = "not asked" if bus.passive else "no answer"
        rows = [_node_row(node, where.device_at(bus.bus.link, node.node), silent) for node in bus.nodes]
        print("\n".join(text_table(_NODE_HEADINGS, rows, left=tuple(range(1, 7)))) if rows else _nobody(bus))
    for line in lines:
        print(f"\nModbus {place(line.options)}: {line.problem or f'{len(line.units)} units answer'}")
        rows = [_unit_row(unit, where.device_at(unit.options.address().link, unit.options.unit_id)) for unit in line.units]
        if rows:
            print("\n".join(text_table(_UNIT_HEADINGS, rows, left=(1, 2, 3, 4))))
        if line.doubtful:
            print(f"unit {', '.join(map(str, line.doubtful))}: device failure alone, as some servers say of units they do not have")
    for missing in _missing(where, buses, lines):
        print(f"not found: {missing}")


_NODE_HEADINGS = ["node", "heard", "profile", "driver", "name", "vendor product revision serial", "in the rig file"]
_UNIT_HEADINGS = ["unit", "input register 0", "holding register 0", "identification", "in the rig file"]


def _node_row(node: FoundNode, device: str, silent: str) -> list[str]:
    heard, known = ", ".join(node.heard) or "-", device or "-"
    if node.identity is None:
        return [str(node.node), heard, silent, "-", "-", "-", known]
    found = node.identity
    profile = f"CiA {found.profile}" if found.profile else "none"
    numbers = (found.vendor, found.product, found.revision, found.serial)
    shown = " ".join("-" if number is None else f"0x{number:X}" for number in numbers)
    return [str(node.node), heard, profile, found.driver or "-", found.name or "-", shown, known]


def _unit_row(unit: FoundUnit, device: str) -> list[str]:
    said = [unit.tables.get(table, "no answer") for table in ("input", "holding")]
    return [str(unit.options.unit_id), *said, unit.identification or "-", device or "-"]


def _rate(interface: str, bitrate: float) -> str:
    return "bit rate of the interface" if interface == "socketcan" else f"{bitrate / 1e3:g} kbit/s"


def _nobody(bus: BusScan) -> str:
    if bus.passive:
        return "Nobody was heard. A node without heartbeat says nothing by itself."
    advice = f"`ip -details link show {bus.bus.channel}`: is it up, " if bus.bus.interface == "socketcan" else "Is the bit rate right, "
    return f"No node answers. {advice}are power, cable and both terminators in place?"


def _missing(where: DeviceLinks, buses: list[BusScan], lines: list[LinkScan]) -> list[str]:
    """Devices of the rig file at places that were looked at."""
    seen = {(bus.bus.link, node.node) for bus in buses for node in bus.nodes}
    seen |= {(unit.options.address().link, unit.options.unit_id) for line in lines for unit in line.units}
    looked = {bus.bus.link for bus in buses} | {line.options.address().link for line in lines if line.asked}
    found = []
    for name, options in where.declared.items():
        address = options.address()
        if address is not None and address.link in looked and (address.link, address.number) not in seen:
            found.append(f"devices.{name}, {address.option} {address.number} on {' '.join(address.link)}")
    return found


def _bus(scan: BusScan, where: DeviceLinks) -> dict[str, Any]:
    from dataclasses import asdict

    nodes = [
        {"node": node.node, "heard": node.heard, "device": where.device_at(scan.bus.link, node.node) or None}
        | {"identity": None if node.identity is None else asdict(node.identity) | _of_profile(node)}
        for node in scan.nodes
    ]
    link = {"interface": scan.bus.interface, "channel": scan.bus.channel, "bitrate": scan.bus.bitrate}
    return {**link, "frames": scan.frames, "error_frames": scan.error_frames, "passive": scan.passive or None, "nodes": nodes}


def _of_profile(node: FoundNode) -> dict[str, Any]:
    assert node.identity is not None
    return {"profile": node.identity.profile, "driver": node.identity.driver or None}


def _line(scan: LinkScan, where: DeviceLinks) -> dict[str, Any]:
    units = [
        {
            "unit": unit.options.unit_id,
            **unit.tables,
            "identification": unit.identification or None,
            "device": where.device_at(unit.options.address().link, unit.options.unit_id) or None,
        }
        for unit in scan.units
    ]
    settings = scan.options.model_dump(include={"transport", "host", "port", "baud_rate", "parity", "stop_bits"})
    return {**settings, "problem": scan.problem or None, "units": units, "doubtful": scan.doubtful}
