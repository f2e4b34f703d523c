"""The proof that outputs go safe by themselves: run in mode PROVING, a step a cycle, remembered for arming and for every recording.

Announced like motion, because valves move. A result that is not ok, or a proof given up, leaves the device unproven.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from datetime import UTC, datetime
from math import ceil, isfinite, nan
from typing import Any

from config.schema.rig import Rig
from daemon.cycle.facts import Facts
from daemon.cycle.log_stream import LogStream
from drivers.contract import KeepsSetup
from drivers.proof import ProofResult, ProofSteps, ProvesSafeState
from recording.format.event import Level

ATTACHMENT = "safe_state_proof.json"


class SafeState:
    """`over` when there is nothing left to prove. The facts DEVICE.proven_s say when each was proven, in the loop's time; NaN: not."""

    def __init__(self, rig: Rig, devices: Mapping[str, object], facts: Facts, log: LogStream) -> None:
        """`devices`: the drivers; those with prove_safe_state() are proven."""
        self._provers = {name: driver for name, driver in devices.items() if isinstance(driver, ProvesSafeState)}
        self._keepers = [(name, driver) for name, driver in self._provers.items() if isinstance(driver, KeepsSetup)]
        self._at = {name: facts.index(fact) for name in self._provers if facts.has(fact := f"{name}.proven_s")}
        self._log = log
        self._rate_Hz = rig.loop.rate_Hz
        self._waiting: deque[tuple[str, ProofSteps]] = deque()
        self._results: dict[str, list[ProofResult]] = {}
        self._proven: dict[str, dict[str, Any]] = {}
        self._countdown = 0

    @property
    def over(self) -> bool:
        return not self._waiting

    def begin(self, values: list[float], countdown_s: float) -> None:
        """What was proven before no longer counts."""
        for index in self._at.values():
            values[index] = nan
        self._proven.clear()
        self._results = {name: [] for name in self._provers}
        self._waiting.extend((name, prover.prove_safe_state()) for name, prover in self._provers.items())
        self._countdown = ceil(countdown_s * self._rate_Hz)
        self._announce()

    def step(self, values: list[float]) -> None:
        """One cycle of it. Raises what a driver raises."""
        if self._countdown > 0:
            self._countdown -= 1
            self._announce()
        elif self._waiting:
            self._prove(values)

    def follow(self, values: list[float]) -> None:
        """Once a cycle: what was proven of a device that has changed since no longer counts."""
        for name, driver in self._keepers:
            if name in self._proven and driver.setup_lost:
                del self._proven[name]
                if name in self._at:
                    values[self._at[name]] = nan
                text = f"{name}: the proof of its safe state no longer counts, because the device {driver.setup_lost}"
                self._log.event(Level.WARNING, "proof_void", f"{text}. `longreach reset`, then `longreach prove` with the pressure off.")

    def give_up(self) -> None:
        """End every proof under way; the caller makes the outputs safe."""
        while self._waiting:
            name, steps = self._waiting.popleft()
            with suppress(Exception):  # whatever a driver raises: the caller makes the outputs safe next
                steps.close()
            self._log.event(Level.ERROR, "not_proven", f"{name}: the proof was given up")

    def evidence(self) -> dict[str, bytes]:
        """What goes into a recording: the proofs that count, as JSON; nothing without one."""
        return {ATTACHMENT: json.dumps(self._proven, indent=1).encode()} if self._proven else {}

    def _prove(self, values: list[float]) -> None:
        name, steps = self._waiting[0]
        try:
            result = next(steps)
        except StopIteration:
            self._waiting.popleft()
            self._judge(name, values)
            if self.over:
                self._log_evidence()
            return
        if result is not None:
            self._results[name].append(result)
            self._log_result(name, result)
            self._waiting.rotate(-1)

    def _judge(self, name: str, values: list[float]) -> None:
        """All proofs of a device are over. One with nothing to prove (no outputs in use) is left out."""
        results = self._results[name]
        if not results:
            return
        failed = [result for result in results if not result.ok]
        if failed:
            self._log.event(Level.ERROR, "not_proven", failed[0].text)
            return
        if name in self._at:
            values[self._at[name]] = self._log.t_s
        when = datetime.fromtimestamp(self._log.now_ns * 1e-9, UTC).isoformat()
        self._proven[name] = {"proven_utc": when, "t_s": self._log.t_s, "results": [asdict(result) for result in results]}
        self._log.event(Level.INFO, "proven", f"{name} goes to its safe state by itself", {"t_s": self._log.t_s})

    def _log_evidence(self) -> None:
        for name, content in self.evidence().items():
            self._log.attach(name, "application/json", content)

    def _log_result(self, name: str, result: ProofResult) -> None:
        values = {"ok": float(result.ok), "limit_s": result.limit_s}
        if isfinite(result.time_to_safe_s):
            values["time_to_safe_s"] = result.time_to_safe_s
        self._log.event(Level.INFO if result.ok else Level.ERROR, "proof", result.text, values)

    def _announce(self) -> None:
        """Every whole second of the countdown."""
        left_s = self._countdown / self._rate_Hz
        whole = round(left_s)
        if whole and abs(left_s - whole) < 0.5 / self._rate_Hz:
            valves = " and ".join(self._provers)
            text = f"proof: the outputs of {valves} move in {whole} s; the hydraulic pressure must be off"
            self._log.event(Level.INFO, "countdown", text, {"countdown_s": whole})
