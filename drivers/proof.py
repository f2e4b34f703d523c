"""What a driver with outputs does when its device's safe state is proven before arming, and what it says about it.

`prove_safe_state()` is called after `configure()` and before `activate()`, with no hydraulic pressure at the valves. It gives steps: the
caller takes one in every cycle, after `read()`. The steps open the output a little, fall silent on purpose, and watch until the device has
made it safe by itself. A step yields None, or the result of a proof that has just ended.

Silence (our heartbeat stops) meets every device on the bus. So a caller with several devices takes turns: it goes on to the next device at
every result, and comes back until all have finished; each device then puts itself in order again. Closing the steps early ends the proof;
the caller then calls `safe()`. A result that is not ok must keep the rig from being armed.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from math import nan
from typing import Protocol, runtime_checkable


@dataclass(frozen=True, slots=True)
class ProofResult:
    """One proof. `time_to_safe_s` runs from the last sign of life we sent; NaN when the device did not become safe."""

    name: str
    ok: bool
    time_to_safe_s: float
    limit_s: float
    text: str


ProofSteps = Generator[ProofResult | None, None, None]


@runtime_checkable
class ProvesSafeState(Protocol):
    """A driver that has this besides the verbs of the driver contract."""

    def prove_safe_state(self) -> ProofSteps: ...


def proof(name: str, time_to_safe_s: float | None, limit_s: float, seen: str) -> ProofResult:
    """The result of a watched time-out; `seen`: what the device said at the end."""
    if time_to_safe_s is None:
        return ProofResult(name, False, nan, limit_s, f"{name}: not safe within {1e3 * limit_s:.0f} ms ({seen})")
    ok = time_to_safe_s <= limit_s
    return ProofResult(
        name, ok, time_to_safe_s, limit_s, f"{name}: safe after {1e3 * time_to_safe_s:.1f} ms, limit {1e3 * limit_s:.0f} ms ({seen})"
    )


def not_proven(name: str, limit_s: float, why: str) -> ProofResult:
    """The proof could not even begin."""
    return ProofResult(name, False, nan, limit_s, f"{name}: not proven, {why}")
