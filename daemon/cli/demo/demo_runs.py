"""The demo's runs: on the wall clock where the machine keeps the rate, else, or after a run that it spoiled, in lockstep."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from config.errors import DaemonError
from config.loading.load import LoadedRig
from daemon.cli.demo.demo_session import wall_clock_run
from daemon.cli.operate.measured_rate import is_simulated
from daemon.lockstep import run_lockstep


class RunDisplay(Protocol):
    """Where the runs are told."""

    def say(self, line: str) -> None: ...

    def status(self, status: dict[str, Any]) -> None: ...

    def share(self, elapsed_s: float, duration_s: float) -> None: ...


@dataclass(slots=True)
class DemoRuns:
    """`lockstep`: why the runs are not on the wall clock; empty while they are. `spoiled`: what the machine did to which run."""

    rig: LoadedRig
    out: Path
    screen: RunDisplay
    lockstep: str = ""
    logs: dict[str, Path] = field(default_factory=dict)
    clocks: dict[str, str] = field(default_factory=dict)
    spoiled: dict[str, str] = field(default_factory=dict)

    def run(self, requests: Mapping[str, Mapping[str, Any]]) -> None:
        """One log a request, by the name of its filter. Raises what the daemon refuses; a spoiled run only of a rig with hardware."""
        for number, (name, request) in enumerate(requests.items(), 1):
            self.screen.say(f"{number} of {len(requests)}: {name}, {'in lockstep' if self.lockstep else 'on the wall clock'}")
            if not self.lockstep:
                self._on_the_wall_clock(name, request)
            if self.lockstep:
                self._in_lockstep(name, request)

    def _on_the_wall_clock(self, name: str, request: Mapping[str, Any]) -> None:
        try:
            self._add(name, "wall", wall_clock_run(Path(self.rig.path), request, self.out, self.screen.status))
        except DaemonError as error:
            if not is_simulated(self.rig.rig):
                raise
            self.spoiled[name] = str(error)
            self.lockstep = f"the machine spoiled the run {name} on the wall clock"
            self.screen.say(f"spoiled by the machine: {error}")
            self.screen.say(f"{name} again, and what is left, in lockstep")

    def _in_lockstep(self, name: str, request: Mapping[str, Any]) -> None:
        def progress(number: int, elapsed_s: float, duration_s: float) -> None:
            self.screen.share(elapsed_s, duration_s)

        self._add(name, "lockstep", run_lockstep(self.rig, [request], self.out, progress=progress)[0])

    def _add(self, name: str, clock: str, log: Path) -> None:
        self.logs[name], self.clocks[name] = log, clock
