"""Device counts → Modbus registers, by the register map of the rig file. (The driver has its own way back; tests compare them.)"""

from __future__ import annotations

import struct
from collections.abc import Mapping

from config.options.modbus_options import REGISTERS, ModbusChannel

_LARGEST_FLOAT32 = 3.4028234e38
_LIMITS = {"int16": (-(1 << 15), (1 << 15) - 1), "uint16": (0, 0xFFFF), "int32": (-(1 << 31), (1 << 31) - 1), "uint32": (0, 0xFFFFFFFF)}


def words(count: float, channel: ModbusChannel) -> list[int]:
    """The registers that show this count. An integer is rounded and stops at the ends of its range; NaN shows as the lowest integer."""
    if channel.type == "float32":
        raw = struct.unpack(">I", struct.pack(">f", max(-_LARGEST_FLOAT32, min(_LARGEST_FLOAT32, count))))[0]
    else:
        low, high = _LIMITS[channel.type]
        raw = (round(max(low, min(high, count))) if count == count else low) & 0xFFFFFFFF
    if REGISTERS[channel.type] == 1:
        return [raw & 0xFFFF]
    pair = [raw >> 16, raw & 0xFFFF]
    return pair if channel.word_order == "big" else pair[::-1]


def span(channels: Mapping[str, ModbusChannel], table: str) -> tuple[int, int]:
    """First address and number of registers of a table; one register at address 0 when it has no channel."""
    used = [channel for channel in channels.values() if channel.table == table]
    first = min((channel.address for channel in used), default=0)
    end = max((channel.address + REGISTERS[channel.type] for channel in used), default=1)
    return first, end - first
