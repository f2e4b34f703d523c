"""`longreach twin` of the shipped CAN rig as a process in a network namespace of its own, and the daemon's rig file that goes with it.

Twin and loop are given a processor each, where there are two: both run with real-time priority and would make each other late.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from config.errors import PlantError
from config.loading.load import apply_overrides, load_rig, rig_from_text
from sim_backend.twin.control_socket import TwinControl
from sim_backend.twin.network_namespace import GROUP, NetworkNamespace

START_LIMIT_S = 120.0  # the first start on a machine compiles the plant
_POLL_S = 0.01
_SHIPPED, _HERE = "interface: socketcan, channel: can0", f"interface: udp_multicast, channel: {GROUP}"
# A shared virtual machine pauses for milliseconds, many times a minute. With these settings that is no fault; with the shipped ones it is.
PATIENCE = (
    "loop.overruns.fault_late=1 s",
    "loop.overruns.stop_after=1000",
    "signals.rotary.position.max_age=50 ms",
    "signals.prismatic.position.max_age=50 ms",
    "signals.tip.acceleration.max_age=200 ms",
    "devices.rotary_valve.timeout=0.5 s",
    "devices.prismatic_valve.timeout=0.5 s",
)
_PATIENT_FRAMES = 40


def processors() -> tuple[int | None, int | None]:
    """One for the twin, another for the loop; (None, None) where there is one only."""
    available = sorted(os.sched_getaffinity(0))
    return (available[0], available[-1]) if len(available) > 1 else (None, None)


def multicast_rig(overrides: Sequence[str] = ()) -> str:
    """The shipped CAN rig on udp_multicast, with these overrides."""
    loop_cpu = processors()[1]
    pinned = [f"loop.cpu={loop_cpu}"] if loop_cpu is not None else []
    return apply_overrides(load_rig("ornl_testbed_can").text.replace(_SHIPPED, _HERE), [*pinned, *overrides])


def late_frames(text: str, missing: int) -> str:
    """The same rig, in which a device is silent only after so many missing frames."""
    for line in {line for line in text.splitlines() if line.startswith("      node: ")}:
        text = text.replace(f"{line}\n", f"{line}\n      missing_frames: {missing}\n")
    return text


def patient(text: str) -> str:
    """The same rig with patience for a busy machine: frames, cycles and heartbeats may be late."""
    return apply_overrides(late_frames(text, _PATIENT_FRAMES), PATIENCE)


class TwinProcess:
    """Use it in a with statement. `control` injects faults; `process` is the twin itself."""

    def __init__(self, namespace: NetworkNamespace, directory: Path, text: str, talks: bool = False) -> None:
        """`text`: the rig file; `talks`: a status line a second on `process.stdout`.

        Raises PlantError with what it said when it does not start.
        """
        self.rig = rig_from_text(text)
        self.rig_file, socket = directory / "twin.yaml", directory / "twin.sock"
        self.rig_file.write_text(text)
        cpu = processors()[0]
        options = ([] if cpu is None else ["--cpu", str(cpu)]) + ([] if talks else ["--quiet"])
        command = [sys.executable, "-m", "daemon.cli.main", "twin", str(self.rig_file), "--control", str(socket), *options]
        self.process = subprocess.Popen([*namespace.prefix, *command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.control = self._answering(socket)

    def close(self) -> None:
        self.control.close()
        self.process.terminate()
        self.process.communicate(timeout=10)

    def __enter__(self) -> TwinProcess:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _answering(self, socket: Path) -> TwinControl:
        end = time.monotonic() + START_LIMIT_S
        while not socket.exists() and self.process.poll() is None and time.monotonic() < end:
            time.sleep(_POLL_S)
        if not socket.exists():
            self.process.kill()
            said = self.process.communicate()[0]
            raise PlantError("the twin did not start", value=said[-500:], limit=START_LIMIT_S, unit="s")
        return TwinControl(socket, timeout_s=10.0)
