"""From a register map to few block reads, and from registers to raw counts. Pure: nothing here talks to a device."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from config.options.modbus_options import REGISTERS, ModbusChannel

LONGEST_READ = 125  # registers in one answer (Modbus application protocol, function 3 and 4)
_NUMBER = {"int16": ">h", "uint16": ">H", "int32": ">i", "uint32": ">I", "float32": ">f"}


@dataclass(frozen=True, slots=True)
class BlockChannel:
    """A channel within a block: its number in the driver's list, its first register counted from the block's start, its type."""

    channel: int
    offset: int
    registers: int
    number: struct.Struct
    low_word_first: bool


@dataclass(frozen=True, slots=True)
class Block:
    """One request: consecutive registers of one table and the channels found in them."""

    table: str
    address: int
    count: int
    places: tuple[BlockChannel, ...]

    def raw_counts(self, registers: Sequence[int]) -> list[tuple[int, float]]:
        """(channel number, raw count) for every channel of the block.

        Raises ValueError when the answer has the wrong number of registers or a register is no 16-bit number.
        """
        if len(registers) != self.count:
            raise ValueError(f"{len(registers)} registers instead of {self.count}")
        return [(place.channel, _number(registers, place)) for place in self.places]


def blocks(channels: Mapping[str, ModbusChannel], largest_gap: int) -> tuple[Block, ...]:
    """The fewest reads that stay within 125 registers and read at most `largest_gap` needless registers between two channels."""
    numbered = sorted(enumerate(channels.values()), key=lambda item: (item[1].table, item[1].address))
    groups: list[list[tuple[int, ModbusChannel]]] = []
    for number, channel in numbered:
        if groups and _joins(groups[-1], channel, largest_gap):
            groups[-1].append((number, channel))
        else:
            groups.append([(number, channel)])
    return tuple(_block(group) for group in groups)


def _joins(group: list[tuple[int, ModbusChannel]], channel: ModbusChannel, largest_gap: int) -> bool:
    first, last = group[0][1], group[-1][1]
    close = channel.address - last.end <= largest_gap
    return channel.table == first.table and close and channel.end - first.address <= LONGEST_READ


def _block(group: list[tuple[int, ModbusChannel]]) -> Block:
    first = group[0][1]
    places = tuple(
        BlockChannel(
            number, channel.address - first.address, REGISTERS[channel.type], struct.Struct(_NUMBER[channel.type]), _low_first(channel)
        )
        for number, channel in group
    )
    return Block(first.table, first.address, max(channel.end for _, channel in group) - first.address, places)


def _low_first(channel: ModbusChannel) -> bool:
    return channel.word_order == "little"


def _number(registers: Sequence[int], place: BlockChannel) -> float:
    words = registers[place.offset : place.offset + place.registers]
    if place.low_word_first:
        words = words[::-1]
    try:
        return float(place.number.unpack(struct.pack(f">{place.registers}H", *words))[0])
    except struct.error as error:
        raise ValueError(f"{list(words)} are not 16-bit registers") from error
