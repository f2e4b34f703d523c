"""/dev/cpu_dma_latency: the kernel's rule is four zero bytes, and the file open for as long as the wish shall hold."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from daemon.host.pm_qos import stay_awake


def open_files() -> set[str]:
    return {os.path.realpath(f"/proc/self/fd/{number}") for number in os.listdir("/proc/self/fd")}


def test_four_zero_bytes_are_written_and_the_file_stays_open(tmp_path: Path) -> None:
    device = tmp_path / "cpu_dma_latency"
    device.write_bytes(b"")
    descriptor = stay_awake(str(device))
    try:
        assert device.read_bytes() == bytes(4)
        assert str(device) in open_files()
    finally:
        os.close(descriptor)


def test_a_device_that_takes_nothing_is_not_left_open() -> None:
    with pytest.raises(OSError, match="No space left"):
        stay_awake("/dev/full")
    assert "/dev/full" not in open_files()


def test_where_there_is_none_it_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        stay_awake(str(tmp_path / "cpu_dma_latency"))
