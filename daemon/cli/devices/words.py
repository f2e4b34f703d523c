"""Words that the device verbs share: where to look, how a link is set, what to read of it. Standard library only."""

from __future__ import annotations

import argparse
from typing import Any

from daemon.cli.options.numbers import COUNT, whole


def add_where(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("where", metavar="WHERE", help="RIG.yaml, INTERFACE:CHANNEL of a CAN bus, tcp:HOST[:PORT] or rtu:PORT")


def add_line_settings(parser: argparse.ArgumentParser, several: bool) -> None:
    """How a bus or line is set where WHERE is no rig file."""
    many: dict[str, Any] = {"nargs": "+"} if several else {}
    parser.add_argument("--bitrate", **many, help="of the CAN bus (default 1 Mbit/s); socketcan has that of its interface")
    parser.add_argument("--baud-rate", type=COUNT, **many, help="of the serial line (default 19200)")
    parser.add_argument("--parity", choices=("none", "even", "odd"), **many, help="of the serial line (default even)")
    parser.add_argument("--stop-bits", type=int, choices=(1, 2), help="of the serial line (default 1)")
    parser.add_argument("--answer-timeout", metavar="TIME", help="of Modbus (default 0.1 s)")


def of_rig(rig: str, device: str) -> argparse.Namespace:
    """The words that mean this device of a rig file, with nothing else said."""
    parser = argparse.ArgumentParser()
    add_device(parser)
    return parser.parse_args([rig, device])


def add_device(parser: argparse.ArgumentParser) -> None:
    """Which device, and what of it where no rig file says so."""
    add_where(parser)
    parser.add_argument("device", nargs="?", help="the rig file's name of the device")
    add_line_settings(parser, several=False)
    parser.add_argument("--node", type=whole(1, 127), help="CANopen node")
    parser.add_argument("--object", nargs="+", default=[], metavar="INDEX[:SUB][/TYPE]", help="objects, for example 6004 or 6401:2/i16")
    parser.add_argument("--eds", metavar="FILE", help="the maker's dictionary (default the shipped one of the node's profile)")
    parser.add_argument("--unit", type=whole(0, 255), help="Modbus unit")
    parser.add_argument("--table", choices=("input", "holding"), help="input (function 4, the default) or holding registers (function 3)")
    parser.add_argument("--address", type=whole(0, 65535), help="first register, counted from 0 (30001 has address 0; default 0)")
    parser.add_argument("--count", type=COUNT, help="how many numbers (default 8)")
    parser.add_argument("--type", choices=("int16", "uint16", "int32", "uint32", "float32"), help="of the numbers (default uint16)")
    parser.add_argument("--word-order", choices=("big", "little"), help="big (the default): the high word stands in the first register")
