"""Hardware in the loop: `longreach twin` as a process of its own in a network namespace, and us in the same namespace."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from config.errors import PlantError
from daemon.faults.benches.twin_process import TwinProcess, multicast_rig
from sim_backend.twin.network_namespace import NetworkNamespace


@pytest.fixture(scope="session")
def namespace() -> Iterator[NetworkNamespace]:
    try:
        namespace = NetworkNamespace(f"longreach-{os.getpid()}")
    except PlantError as reason:
        pytest.skip(str(reason))
    yield namespace
    namespace.delete()


@pytest.fixture
def inside(namespace: NetworkNamespace) -> Iterator[None]:
    """The test itself is in the namespace: its buses and sockets are."""
    with namespace.entered():
        yield


@pytest.fixture(scope="module")
def twin(namespace: NetworkNamespace, tmp_path_factory: pytest.TempPathFactory) -> Iterator[TwinProcess]:
    """One process for a module: it takes seconds to start. Its faults are cleared by `healthy`."""
    with TwinProcess(namespace, tmp_path_factory.mktemp("twin"), multicast_rig(), talks=True) as running:
        yield running


@pytest.fixture
def healthy(twin: TwinProcess) -> Iterator[TwinProcess]:
    """The twin without faults, before and after."""
    twin.control.clear()
    yield twin
    if twin.process.poll() is None:
        twin.control.clear()
