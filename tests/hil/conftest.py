"""Hardware in the loop: `longreach twin` as a process of its own in a network namespace, and us in the same namespace."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from twin_process import TwinProcess

from config.errors import PlantError
from config.load import load_rig, rig_from_text
from sim_backend.twin.control_socket import TwinControl
from sim_backend.twin.network_namespace import GROUP, NetworkNamespace

SHIPPED, OURS = "interface: socketcan, channel: can0", f"interface: udp_multicast, channel: {GROUP}"


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
    place = tmp_path_factory.mktemp("twin")
    text = load_rig("ornl_testbed_can").text.replace(SHIPPED, OURS)
    rig_file, socket = place / "rig.yaml", place / "twin.sock"
    rig_file.write_text(text)
    command = [sys.executable, "-m", "daemon.cli.main", "twin", str(rig_file), "--control", str(socket)]
    process = subprocess.Popen([*namespace.prefix, *command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    running = TwinProcess(process, rig_from_text(text), rig_file, _control_of(process, socket))
    yield running
    running.control.close()
    process.terminate()
    process.communicate(timeout=10)


@pytest.fixture
def healthy(twin: TwinProcess) -> Iterator[TwinProcess]:
    """The twin without faults, before and after."""
    twin.control.clear()
    yield twin
    if twin.process.poll() is None:
        twin.control.clear()


def _control_of(process: subprocess.Popen[str], socket: Path) -> TwinControl:
    end = time.monotonic() + 60  # the first start on a machine compiles the plant
    while not socket.exists():
        assert process.poll() is None, process.communicate()[0]
        assert time.monotonic() < end, "the twin does not start"
        time.sleep(0.01)
    control = TwinControl(socket)
    while "rotary_valve" not in control.describe():
        assert time.monotonic() < end
    return control
