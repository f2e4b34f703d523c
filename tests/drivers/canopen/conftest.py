"""A bus whose frames stay on this machine."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from config.errors import ConfigError
from config.options.multicast import EXAMPLE_GROUP, refuse_leaking_multicast
from tests.support.drivers.local_nodes import NodeBench


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
