"""One trial of a fault of a device or a bus: daemon and twin on the wall clock, CAN and Modbus between them, and the twin says when its
valves were safe.

Twin and daemon go on from trial to trial; only what a fault has broken for good is started anew.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

from config.errors import DaemonError, LongreachError, PlantError
from daemon.faults.benches.commissioning import commission
from daemon.faults.benches.daemon_process import DaemonProcess, hold, move
from daemon.faults.benches.lockstep_bench import reaction_event, short
from daemon.faults.benches.twin_process import TwinProcess, late_frames, multicast_rig
from daemon.faults.fault import NEVER_MS, FaultTrial, Until
from daemon.faults.injections import send_failure
from daemon.server.protocol import Client
from sim_backend.twin.control_socket import TwinControl
from sim_backend.twin.network_namespace import NetworkNamespace

VALVES = ("rotary_valve", "prismatic_valve")
# What a shared machine needs that a rig does not: it pauses for 3 ms many times a minute, which must not count as the fault.
FORGIVEN = ("signals.rotary.position.max_age=12 ms", "signals.prismatic.position.max_age=12 ms")
FORGIVEN_FRAMES = 5
SPEED, WAY_DEG = "55 deg/s", 75
SAFE_FOR_MS, RENEWED_FOR_MS = 150.0, 500.0
_POLL_S = 0.002
_TRIES = 5
_REARM_LIMIT_S = 3.0


class TwinBench:
    """Use it in a with statement. `impossible` says why there can be no trial here; empty when there can.

    `make_room` ends what else has a loop: this daemon and its twin take two processors, and real-time loops starve each other.
    """

    def __init__(self, make_room: Callable[[], None] = lambda: None) -> None:
        self.impossible = ""
        self._make_room = make_room
        self._workspace = TemporaryDirectory(prefix="longreach-twin-")
        self._namespace: NetworkNamespace | None = None
        self._twin: TwinProcess | None = None
        self._daemon: DaemonProcess | None = None
        self._client: Client | None = None
        self._started = self._events_before = 0

    def __enter__(self) -> TwinBench:
        try:
            self._namespace = NetworkNamespace(f"longreach-faults-{os.getpid()}")
        except PlantError as error:
            self.impossible = str(error)
        return self

    def __exit__(self, *error: object) -> None:
        self.end_daemon()
        if self._twin:
            self._twin.close()
        if self._namespace:
            self._namespace.delete()
        self._workspace.cleanup()

    @property
    def twin(self) -> TwinControl:
        assert self._twin is not None
        return self._twin.control

    @property
    def daemon(self) -> DaemonProcess:
        assert self._daemon is not None
        return self._daemon

    @property
    def client(self) -> Client:
        assert self._client is not None
        return self._client

    def fill_send_queue(self) -> int:
        """No frame of the daemon leaves any more. Returns when this began."""
        send_failure.switch(self._directory, is_full=True)
        return time.monotonic_ns()

    def signal(self, number: int, *names: str) -> int:
        """To processes of the daemon. Returns when this began."""
        began_ns = time.monotonic_ns()
        self.daemon.signal(number, *names)
        return began_ns

    def moving(self, rng: Random) -> None:
        """Returns at a random instant of a fast move without any fault. DaemonError when that cannot be reached."""
        self._make_room()
        last = ""
        for tries in range(_TRIES):
            try:
                self._hold()
                move(self.client, WAY_DEG, SPEED)
                time.sleep(0.2 * rng.random())
                self._events_before = self.client.call("events")["last"]
                if self.client.call("status")["mode"] == "running":
                    return
            except (LongreachError, OSError) as error:
                last = str(error)
                if tries:
                    self.end_daemon()
        raise DaemonError("no fault-free motion", value=f"{_TRIES} tries", next_step=f"Is the machine too busy? {last}")

    def reaction(self) -> str:
        """The daemon's first reaction after the injection; overruns do not count, they are the computer's."""
        with suppress(LongreachError, OSError):
            events = [event for event in self.client.call("events", since=self._events_before)["events"] if event["name"] != "overrun"]
            found = reaction_event(events)
            return short(found) if found else "none: the run goes on"
        return "the daemon does not answer"

    def end_daemon(self) -> None:
        client, self._client = self._client, None
        if client:
            client.close()
        daemon, self._daemon = self._daemon, None
        if daemon:
            daemon.end()

    def _hold(self) -> None:
        """Twin without faults, daemon holding the arm."""
        if self._twin is None:
            assert self._namespace is not None
            self._twin = TwinProcess(self._namespace, Path(self._workspace.name), self._rig)
        self.twin.clear()
        if self._daemon is None or self.daemon.exit_status() is not None:
            self.end_daemon()
            self._start_daemon()
            return
        send_failure.switch(self._directory, is_full=False)
        hold(self.client, _REARM_LIMIT_S)

    def _start_daemon(self) -> None:
        assert self._namespace is not None
        self._started += 1
        self._directory = Path(self._workspace.name) / f"daemon-{self._started}"
        self._directory.mkdir()
        environment = send_failure.environment(self._directory)
        self._daemon = DaemonProcess(self._directory, text=self._rig, environment=environment, prefix=self._namespace.prefix)
        self._client = self._daemon.connect()
        commission(self._client, self.twin)

    @property
    def _rig(self) -> str:
        return late_frames(multicast_rig(FORGIVEN), FORGIVEN_FRAMES)


Inject = Callable[[TwinBench], int]  # returns when it began, in ns of the monotonic clock
After = Callable[[TwinBench], str]


def twin_trial(
    bench: TwinBench, inject: Inject, until: Until, longest_ms: float, after: After = TwinBench.reaction, reusable: bool = True
) -> Callable[[Random, Path], FaultTrial]:
    """A trial that injects by `inject` while the rotary joint moves, and asks the twin until `until`.

    `after` gives the reaction once the time is measured; `again` = False: the daemon cannot be used for another trial.
    """

    def run(rng: Random, directory: Path) -> FaultTrial:
        bench.moving(rng)
        injected_ns = inject(bench)
        time_ms, timed_out = _watch(bench.twin, until, injected_ns, longest_ms)
        reaction = ("device time-out; " if timed_out else "") + after(bench)
        if until is Until.SAFE and _safe_since(bench.twin.describe()) is None:
            reaction = f"outputs act again: {reaction}"
        if not reusable:
            bench.end_daemon()
        return FaultTrial(time_ms, reaction)

    return run


def _watch(twin: TwinControl, until: Until, injected_ns: int, longest_ms: float) -> tuple[float, bool]:
    """(ms from the injection until the outputs were safe and stayed so, or the longest pause; whether a valve's own supervision acted)."""
    while (now_ns := time.monotonic_ns()) - injected_ns < longest_ms * 1e6:
        devices = twin.describe()
        if until is Until.RENEWED and now_ns - injected_ns >= RENEWED_FOR_MS * 1e6:
            return max(devices[name]["longest_pause_ns"] for name in VALVES) * 1e-6, False
        safe_ns = _safe_since(devices)
        if until is Until.SAFE and safe_ns is not None and now_ns - safe_ns >= SAFE_FOR_MS * 1e6:
            return max(0.0, (safe_ns - injected_ns) * 1e-6), any(devices[name]["state"].startswith("FAULT") for name in VALVES)
        time.sleep(_POLL_S)
    return NEVER_MS, False


def _safe_since(devices: Mapping[str, Any]) -> int | None:
    """When the last spool reached its valve's safe position, as the twin reports; None while one is not there."""
    since = [devices[name].get("safe_since_ns") for name in VALVES]
    return None if None in since else max(since)
