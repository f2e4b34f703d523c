"""One process a link, and the kernel takes the claim back whatever becomes of its holder."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from config.errors import DriverError
from drivers.link_claim import LinkClaim, holder
from tests.support.daemon.running_daemon import until

HOLD = "from drivers.link_claim import LinkClaim; claim = LinkClaim({link!r}); print('held', flush=True); input()"


def test_another_process_is_named_and_its_death_frees_the_link() -> None:
    link = ("CAN", "socketcan", f"test{os.getpid()}")
    other = subprocess.Popen([sys.executable, "-c", HOLD.format(link=link)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        assert holder(link) == other.pid
        with pytest.raises(DriverError, match=f"speaks on CAN socketcan test{os.getpid()}: process {other.pid}"):
            LinkClaim(link)
        assert holder(("CAN", "socketcan", "another")) is None
    finally:
        other.kill()
        other.wait()
    until(lambda: holder(link) is None, 10.0)
    LinkClaim(link).release()
    assert holder(link) is None


def test_a_bus_within_one_process_needs_no_claim() -> None:
    link = ("CAN", "virtual", "a")
    first, second = LinkClaim(link), LinkClaim(link)
    assert holder(link) is None
    first.release()
    second.release()
