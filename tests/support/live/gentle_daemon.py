"""A daemon that tests of what is watched and driven share: on the gentle rig, ready, and holding where it is to be driven."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from daemon.server.protocol import Client
from tests.support.daemon.running_daemon import RunningDaemon
from tests.support.live.gentle_rig import gentle_rig


@contextmanager
def gentle_daemon(directory: Path) -> Iterator[RunningDaemon]:
    """Ready and disarmed."""
    with RunningDaemon(directory, gentle_rig(directory)) as daemon:
        daemon.wait_until_ready().close()
        yield daemon


@contextmanager
def holding(daemon: RunningDaemon) -> Iterator[Client]:
    """The arm holds; afterwards it is disarmed. A fault that was latched before is reset."""
    with Client(daemon.socket) as client:
        client.call("reset")
        client.call("arm")
        yield client
        client.call("disarm")
