"""Register maps without a device: merging by its own laws, and garbage answers."""

from __future__ import annotations

from contextlib import nullcontext
from functools import cache

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from config.errors import ConfigError, DriverError
from config.options.driver_options import device_options
from config.options.modbus_options import REGISTERS, ModbusChannel, RtuOptions, TcpOptions
from config.schema.rig import Device
from drivers.contract import Quality
from drivers.modbus import ModbusDriver
from drivers.modbus_client import ModbusReadError
from drivers.modbus_registers import LONGEST_READ, blocks

CHANNEL = st.builds(
    ModbusChannel,
    table=st.sampled_from(["input", "holding"]),
    address=st.integers(0, 700),
    type=st.sampled_from(sorted(REGISTERS)),
    word_order=st.sampled_from(["big", "little"]),
)
MAPS = st.dictionaries(st.text("abcdef", min_size=1, max_size=3), CHANNEL, min_size=1, max_size=30)


@settings(max_examples=500, deadline=None)
@given(MAPS, st.integers(0, 120))
def test_merged_blocks_hold_every_channel_once_and_within_the_limits(channels: dict[str, ModbusChannel], gap: int) -> None:
    merged = blocks(channels, gap)
    ordered = list(channels.values())
    placed = sorted(place.channel for block in merged for place in block.places)
    assert placed == list(range(len(ordered)))
    for block in merged:
        assert 1 <= block.count <= LONGEST_READ
        used = set()
        for place in block.places:
            channel = ordered[place.channel]
            assert channel.table == block.table
            assert channel.address == block.address + place.offset
            used |= set(range(place.offset, place.offset + REGISTERS[channel.type]))
        assert max(used) < block.count
        empty = sorted(set(range(block.count)) - used)
        runs = 0
        for here in empty:
            runs = runs + 1 if here - 1 in empty else 1
            assert runs <= gap


@settings(max_examples=300, deadline=None)
@given(MAPS)
def test_overlap_is_found_exactly_when_a_register_is_used_twice(channels: dict[str, ModbusChannel]) -> None:
    used = [(c.table, c.address + number) for c in channels.values() for number in range(REGISTERS[c.type])]
    written = {name: channel.model_dump() for name, channel in channels.items()}
    is_shared = len(used) != len(set(used))
    with pytest.raises(ConfigError, match="share a register") if is_shared else nullcontext():
        tcp_options(written)


class Garbage:
    """A connection that gives whatever it was made of, or fails."""

    def __init__(self, answers: list[object]) -> None:
        self.answers = answers

    def connect(self) -> None:
        if self.answers and self.answers[0] is None:
            self.answers.pop(0)
            raise ModbusReadError("no connection", answered=False)

    def read(self, table: str, address: int, count: int) -> object:
        answer = self.answers.pop(0) if self.answers else [0] * count
        if answer is None:
            raise ModbusReadError("no answer", answered=False)
        if answer == "refused":
            raise ModbusReadError("exception 4", answered=True)
        return answer

    def close(self) -> None:
        pass


ANSWERS = st.lists(st.none() | st.just("refused") | st.lists(st.integers(-70000, 70000), max_size=6), max_size=20)


@pytest.mark.slow
@settings(max_examples=2000, deadline=None)
@given(ANSWERS, st.integers(0, 2_000_000_000))
def test_no_answer_whatever_makes_the_driver_fail_or_lie(answers: list[object], step_ns: int) -> None:
    driver = ModbusDriver("gauges", _two_gauges(), lambda _: Garbage(answers))
    if answers[:1] == [None]:
        with pytest.raises(DriverError, match="no connection"):
            driver.open()
        return
    driver.open()
    for number in range(12):
        for sample in driver.read(number * step_ns):
            assert sample.quality in (Quality.GOOD, Quality.BAD)
            assert (sample.raw == sample.raw) == (sample.quality == Quality.GOOD)


def tcp_options(channels: dict[str, dict[str, object]]) -> TcpOptions | RtuOptions:
    return device_options("gauges", Device(driver="modbus", slow=True, options={"transport": "tcp", "host": "none", "channels": channels}))


@cache
def _two_gauges() -> TcpOptions | RtuOptions:
    return tcp_options({"a": {"address": 0, "type": "int32"}, "b": {"table": "holding", "address": 9, "type": "float32"}})


@pytest.mark.parametrize("registers", [[1], [1, 2, 3], [1, 70000], [-1, 0]])
def test_answers_of_the_wrong_shape_are_refused(registers: list[int]) -> None:
    (block,) = blocks({"a": ModbusChannel(address=0, type="int32")}, 0)
    with pytest.raises(ValueError, match="registers"):
        block.raw_counts(registers)
