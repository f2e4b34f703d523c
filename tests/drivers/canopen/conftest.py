"""Paths of the shared contract test, and a bus whose frames stay on this machine."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from local_nodes import NodeBench

from config.errors import ConfigError
from config.multicast import EXAMPLE_GROUP, refuse_leaking_multicast


@pytest.fixture
def bench(request: pytest.FixtureRequest) -> Iterator[NodeBench]:
    """Simulated nodes on a virtual bus that no other test uses."""
    with NodeBench(request.node.nodeid) as made:
        yield made


@pytest.fixture
def multicast_channel() -> str:
    """The channel of a udp_multicast bus; skips unless the kernel would send its frames to the loopback device only."""
    try:
        refuse_leaking_multicast(EXAMPLE_GROUP)
    except ConfigError as leak:
        pytest.skip(str(leak))
    return EXAMPLE_GROUP
