"""Paths of the shared contract test, and the guard that keeps CAN frames from leaving the machine."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from local_nodes import NodeBench

MULTICAST_GROUP = "239.74.163.2"


@pytest.fixture
def bench(request: pytest.FixtureRequest) -> Iterator[NodeBench]:
    """Simulated nodes on a virtual bus that no other test uses."""
    with NodeBench(request.node.nodeid) as made:
        yield made


@pytest.fixture
def multicast_channel() -> str:
    """The channel of a udp_multicast bus; skips unless the kernel would send its frames to the loopback device only."""
    try:
        route = subprocess.run(["ip", "-4", "route", "get", MULTICAST_GROUP], capture_output=True, text=True, check=False)
    except FileNotFoundError:
        pytest.skip("no `ip` command: cannot see where multicast frames would go")
    if " dev lo " not in f"{route.stdout} ":
        seen = (route.stdout or route.stderr).strip()
        pytest.skip(f"udp_multicast frames would leave this machine: {seen!r}; run in a namespace with a multicast route on lo")
    return MULTICAST_GROUP
