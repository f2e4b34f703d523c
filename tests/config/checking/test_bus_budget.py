"""Bus load against a bit stuffer that is written out, and what `check` says when a bus is too full."""

from __future__ import annotations

import datetime
import re

import pytest

from config.checking.bus_budget import bus_loads, check_bus_budget, worst_case_bits
from config.checking.check import check_rig
from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text
from config.parsing.yaml_tree import parse
from config.schema.rig import Rig

TODAY = datetime.date(2026, 1, 1)
CAN = load_rig("ornl_testbed_can")
TREE = parse(CAN.text, "can.yaml")


def changed(*overrides: str) -> Rig:
    return rig_from_text(apply_overrides(CAN.text, list(overrides)))


def replaced(old: str, new: str) -> Rig:
    assert old in CAN.text
    return rig_from_text(CAN.text.replace(old, new))


def stuffed_bits(bits: str) -> int:
    """Length after stuffing: five equal bits in a row (stuff bits count) are followed by the opposite one."""
    out = ""
    for bit in bits:
        out += bit
        if out[-5:] in ("00000", "11111"):
            out += "1" if bit == "0" else "0"
    return len(out)


@pytest.mark.parametrize("data_bytes", range(9))
def test_worst_case_is_what_the_worst_bit_pattern_needs(data_bytes: int) -> None:
    """The pattern that stuffs most: five equal bits, then groups of four of alternating value, each completed by a stuff bit."""
    stuffable = 34 + 8 * data_bytes
    worst = ""
    bit = "0"
    while len(worst) < stuffable:
        worst += bit * (5 if not worst else 4)
        bit = "1" if bit == "0" else "0"
    after_crc = 1 + 2 + 7 + 3  # CRC delimiter, acknowledge and its delimiter, end of frame, gap
    assert worst_case_bits(data_bytes) == stuffed_bits(worst[:stuffable]) + after_crc


def test_sizes_known_from_the_literature() -> None:
    assert [worst_case_bits(size) for size in (0, 4, 8)] == [55, 95, 135]


def test_the_shipped_rig_counts_frame_by_frame() -> None:
    (load,) = bus_loads(CAN.rig)
    cyclic_bits = 55 + 2 * 135 + 4 * 95
    rarer_bits_per_s = 5 * 65 * 10 + 65 * 50 + 95 * 250
    assert load.load == pytest.approx((cyclic_bits * 1000 + rarer_bits_per_s) / 1e6)
    assert load.text().startswith(
        "can0: 7 frames/cycle at 1000 Hz = 73.5 % of 1 Mbit/s, limit 75 %: SYNC 55 bits, rotary_encoder TPDO1 135 bits"
    )


def test_an_overfull_bus_is_an_error_that_names_every_frame_and_the_rate_that_fits() -> None:
    rig = replaced("load_limit: 75 %", "load_limit: 70 %")
    (finding,) = check_bus_budget(rig, TREE)
    assert finding.level == "error"
    for name in ("SYNC", "rotary_encoder TPDO1", "prismatic_encoder TPDO1", "rotary_valve RPDO1", "prismatic_valve TPDO1", "our heartbeat"):
        assert name in finding.text
    assert "limit 70 %" in finding.text
    assert "Lower loop.rate to 952 Hz" in finding.text
    slower = rig_from_text(CAN.text.replace("load_limit: 75 %", "load_limit: 70 %").replace("rate: 1 kHz", "rate: 950 Hz"))
    assert [found.level for found in check_bus_budget(slower, TREE)] == ["ok"]


def test_half_the_bit_rate_is_twice_the_load() -> None:
    (load,) = bus_loads(replaced("bitrate: 1 Mbit/s", "bitrate: 500 kbit/s"))
    assert load.load == pytest.approx(2 * bus_loads(CAN.rig)[0].load)
    assert "of 0.5 Mbit/s" in load.text()


def test_check_tells_the_load() -> None:
    texts = {finding.text: finding.level for finding in check_rig(CAN, TODAY)}
    assert [level for text, level in texts.items() if text.startswith("can0: 7 frames/cycle")] == ["ok"]
    text = CAN.text.replace("load_limit: 75 %", "load_limit: 70 %")
    errors = [finding.text for finding in check_rig(LoadedRig(rig_from_text(text), text, "full.yaml"), TODAY) if finding.level == "error"]
    assert len(errors) == 1


def test_a_rig_without_can_has_no_bus() -> None:
    assert bus_loads(load_rig("ornl_testbed").rig) == []


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("node: 12", "node: 11", r"prismatic_valve.*'rotary_valve' on CAN can0 has this number too: 11"),
        ("node: 12", "node: 127", r"prismatic_valve.*is our own number, bus.own_node: 127"),
        ("node: 12", "node: 0", r"prismatic_valve.*node is out of range: 0 .limit: 1 to 127"),
        ("every_syncs: 4", "every_sync: 4", r"tip_sensors.*every_sync.*every_syncs"),
        ("resolution: 72000 ", "resolution: fine ", r"rotary_encoder.*resolution"),
        (
            "bitrate: 1 Mbit/s, load_limit: 75 %}\n      node: 12",
            "bitrate: 500 kbit/s, load_limit: 75 %}\n      node: 12",
            r"prismatic_valve and devices.rotary_encoder are on one link and differ in bus.bitrate: 500000.0 .limit: rotary_encoder: 1",
        ),
    ],
)
def test_options_that_cannot_be_used_are_named_with_their_line(old: str, new: str, text: str) -> None:
    """Whether a bus is overloaded can be told without what is wrong with one device, but not the other way round."""
    assert CAN.text.count(old) == 1
    changed = CAN.text.replace(old, new)
    line = 1 + CAN.text[: CAN.text.index(old)].count("\n")
    errors = [each.text for each in check_rig(LoadedRig(rig_from_text(changed), changed, "can.yaml"), TODAY) if each.level == "error"]
    (found,) = [error for error in errors if "frames/cycle" not in error]
    assert re.match(rf"can.yaml:{line}:\d+: .*{text}", found), found
