"""CiA 406 encoder: what a frame means, what happens when frames are late, lost, short, or say that the encoder is in trouble."""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import pairwise

import pytest

from config.errors import DriverError
from drivers.canopen.encoder_406 import EncoderDriver
from drivers.contract import Quality, Sample
from tests.support.drivers.canopen_rig import encoder
from tests.support.drivers.local_nodes import EncoderNode, NodeBench

MS = 1_000_000


@pytest.fixture
def pair(bench: NodeBench) -> Iterator[tuple[EncoderNode, EncoderDriver]]:
    node = EncoderNode(bench, 3)
    driver = encoder(bench.channel, 3)
    driver.open()
    driver.configure()
    driver.read(time.monotonic_ns())
    bench.settle()
    yield node, driver
    driver.close()


def after_sync(bench: NodeBench, driver: EncoderDriver) -> list[Sample]:
    """The samples that answer the SYNC of one more cycle."""
    driver.read(time.monotonic_ns())
    bench.settle()
    return list(driver.read(time.monotonic_ns()))


@pytest.mark.parametrize(("position", "speed"), [(0, 0), (1, -1), (0x01020304, 0x0506), (2**32 - 1, -(2**15)), (123456789, 2**15 - 1)])
def test_counts_are_those_the_encoder_put_into_its_frame(
    bench: NodeBench, pair: tuple[EncoderNode, EncoderDriver], position: int, speed: int
) -> None:
    node, driver = pair
    node.position, node.speed = position, speed
    samples = after_sync(bench, driver)
    assert [sample.raw for sample in samples] == [position, speed]
    assert [sample.quality for sample in samples] == [Quality.GOOD, Quality.GOOD]


def test_bytes_of_a_frame_by_place_value(bench: NodeBench, pair: tuple[EncoderNode, EncoderDriver]) -> None:
    """Without any packing code: byte k counts 256**k, the speed's top bit counts negative."""
    node, driver = pair
    node.silent = True
    data = [0x11, 0x22, 0x33, 0xF4, 0xFE, 0xFF, 0x00, 0x00]
    node.send(0x180 + 3, bytes(data))
    samples = driver.read(time.monotonic_ns())
    assert samples[0].raw == 0x11 + 0x22 * 256 + 0x33 * 256**2 + 0xF4 * 256**3
    assert samples[1].raw == 0xFE + 0xFF * 256 - 2**16


@pytest.mark.parametrize("bit", range(16))
def test_every_alarm_bit_makes_the_position_bad(bench: NodeBench, pair: tuple[EncoderNode, EncoderDriver], bit: int) -> None:
    node, driver = pair
    node.alarms = 1 << bit
    assert after_sync(bench, driver)[0].quality == Quality.BAD
    node.alarms = 0
    assert after_sync(bench, driver)[0].quality == Quality.GOOD


def test_an_emergency_makes_samples_uncertain_until_it_is_over(bench: NodeBench, pair: tuple[EncoderNode, EncoderDriver]) -> None:
    node, driver = pair
    node.local.emcy.send(0x5000)
    assert after_sync(bench, driver)[0].quality == Quality.UNCERTAIN
    assert driver.emergency == 0x5000
    node.local.emcy.send(0)
    assert after_sync(bench, driver)[0].quality == Quality.GOOD


def test_lost_frames_let_the_age_grow_and_then_the_quality_fall(bench: NodeBench, pair: tuple[EncoderNode, EncoderDriver]) -> None:
    node, driver = pair
    node.position = 77
    sample = after_sync(bench, driver)[0]
    stamp = sample.stamp_ns
    bench.settle()
    node.silent = True
    driver.read(time.monotonic_ns())  # what was still on its way
    seen = []
    start = time.monotonic_ns()
    for cycle in range(1, 5):
        now = start + cycle * MS
        seen.append((driver.read(now)[0].quality, now - sample.stamp_ns))
    assert sample.raw == 77
    assert sample.stamp_ns >= stamp
    assert [quality for quality, _ in seen] == [Quality.UNCERTAIN, Quality.UNCERTAIN, Quality.BAD, Quality.BAD]
    ages = [age for _, age in seen]
    assert [later - earlier for earlier, later in pairwise(ages)] == [MS] * 3
    assert driver.lost == 1, "after three missing frames the first of them is given up"
    node.silent = False
    assert after_sync(bench, driver)[0].quality == Quality.GOOD


def test_before_the_first_frame_there_is_nothing_to_believe(bench: NodeBench) -> None:
    EncoderNode(bench, 3).silent = True
    driver = encoder(bench.channel, 3)
    driver.open()
    sample = driver.read(time.monotonic_ns())[0]
    assert sample.quality == Quality.BAD
    assert sample.raw != sample.raw
    driver.close()


@pytest.mark.parametrize("length", [0, 1, 6, 7])
def test_a_frame_of_the_wrong_size_is_counted_and_not_used(bench: NodeBench, pair: tuple[EncoderNode, EncoderDriver], length: int) -> None:
    node, driver = pair
    node.position = 5
    after_sync(bench, driver)
    node.silent = True
    node.send(0x180 + 3, bytes([0xAA] * length))
    assert driver.read(time.monotonic_ns())[0].raw == 5
    assert driver.malformed == 1


@pytest.mark.parametrize(("state", "text"), [(0, "restarted by itself and has lost its settings"), (127, "left OPERATIONAL by itself")])
def test_a_device_that_must_be_set_up_again_says_so_until_it_is(
    bench: NodeBench, pair: tuple[EncoderNode, EncoderDriver], state: int, text: str
) -> None:
    node, driver = pair
    assert (driver.setup_lost, driver.needs_setup) == ("", False)
    node.send(0x700 + 3, bytes([state]))
    for _ in range(2):
        with pytest.raises(DriverError, match=rf"encoder: node 3: the device {text}.*longreach reset"):
            driver.read(time.monotonic_ns())
        node.send(0x700 + 3, b"\5")  # that it runs does not bring its settings back
    assert driver.setup_lost.startswith(text)
    assert driver.needs_setup
    driver.configure()
    assert (driver.setup_lost, driver.needs_setup) == ("", False)
    assert after_sync(bench, driver)[0].quality == Quality.GOOD


def test_a_device_that_left_because_of_our_silence_has_kept_its_settings(bench: NodeBench, pair: tuple[EncoderNode, EncoderDriver]) -> None:
    node, driver = pair
    node.local.emcy.send(0x8130)
    node.send(0x700 + 3, b"\x7f")
    driver.read(time.monotonic_ns())
    assert driver.setup_lost == ""
    assert driver.needs_setup, "it does not run"


def test_wrong_resolution_is_another_device(bench: NodeBench) -> None:
    node = EncoderNode(bench, 4)
    node.local.data_store[0x6501] = {0: (4096).to_bytes(4, "little")}
    driver = encoder(bench.channel, 4, resolution=8192)
    driver.open()
    with pytest.raises(
        DriverError, match=r"node 4: object 0x6501 sub-index 0 \(resolution\).*found 4096 \(0x1000\) \(limit: wanted 8192 \(0x2000\)\)"
    ):
        driver.configure()
    driver.close()


def test_lockstep_is_refused(bench: NodeBench) -> None:
    with pytest.raises(DriverError, match="real time"):
        encoder(bench.channel, 3, lockstep=True)


def test_opening_twice_is_refused(bench: NodeBench) -> None:
    driver = encoder(bench.channel, 3)
    driver.open()
    with pytest.raises(DriverError, match="open already"):
        driver.open()
    driver.close()


def test_every_cycle_with_a_frame_older_than_2_ms_is_counted(bench: NodeBench, pair: tuple[EncoderNode, EncoderDriver]) -> None:
    """The count is compared with the ages of the samples, which is how the loop would find out."""
    node, driver = pair
    after_sync(bench, driver)
    driver.stale = old = 0
    for cycle in range(30):
        node.silent = cycle % 5 == 1
        later = time.monotonic_ns() + (3 * MS if cycle % 2 else 0)  # a loop that looks late at a frame that came in time
        bench.settle()
        while time.monotonic_ns() < later:
            bench.settle()
        now_ns = time.monotonic_ns()
        sample = driver.read(now_ns)[0]
        old += now_ns - sample.stamp_ns > 2 * MS
    assert driver.stale == old >= 15
