"""What a device shows when its safe state is proven before arming.

`prove_safe_state()` of a driver with outputs is called after `configure()` of every device and before `activate()`, outside the loop,
with no hydraulic pressure at the valves: it brings the output off its safe value, stops what the device supervises, and watches. It
takes about two time-outs a device. A result that is not ok must keep the rig from being armed.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import nan


@dataclass(frozen=True, slots=True)
class ProofResult:
    """One proof. `time_to_safe_s` runs from the last sign of life we sent; NaN when the device did not become safe."""

    name: str
    ok: bool
    time_to_safe_s: float
    limit_s: float
    text: str


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
