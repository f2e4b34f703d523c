"""Drivers with the options a rig file would give them, on a bus of the test's own."""

from __future__ import annotations

import time
from typing import Any

from config.options.canopen_options import EncoderOptions, IoOptions, ValveOptions
from drivers.canopen.encoder_406 import EncoderDriver
from drivers.canopen.io_401 import IoDriver
from drivers.canopen.output_device import OutputDevice
from drivers.canopen.valve_408 import ValveDriver
from drivers.proof import ProofResult

TIMEOUT_S = 0.06
HEARTBEAT_S = TIMEOUT_S / 3
REACTIONS = {75: 2, 77: 2}  # of the valve in local_nodes: lost heartbeat, missing set points


def bus(channel: str) -> dict[str, Any]:
    return {"interface": "virtual", "channel": channel}


def encoder(channel: str, node: int, lockstep: bool = False, **options: Any) -> EncoderDriver:
    checked = EncoderOptions.model_validate({"bus": bus(channel), "node": node, "heartbeat": 0.02, **options})
    return EncoderDriver("encoder", checked, HEARTBEAT_S, lockstep)


def valve(channel: str, node: int, **options: Any) -> ValveDriver:
    plain = {"bus": bus(channel), "node": node, "heartbeat": 0.02, "fault_reactions": REACTIONS, **options}
    return ValveDriver("valve", ValveOptions.model_validate(plain), TIMEOUT_S, HEARTBEAT_S, lockstep=False)


def io_module(channel: str, node: int, **options: Any) -> IoDriver:
    checked = IoOptions.model_validate({"bus": bus(channel), "node": node, "heartbeat": 0.02, **options})
    return IoDriver("io", checked, TIMEOUT_S, HEARTBEAT_S, lockstep=False)


def proven(*drivers: OutputDevice, period_s: float = 1e-3) -> list[ProofResult]:
    """The proofs of these devices, in turns, with cycles as a loop has them."""
    waiting, results = [driver.prove_safe_state() for driver in drivers], []
    while waiting:
        time.sleep(period_s)
        now = time.monotonic_ns()
        for driver in drivers:
            driver.read(now)
        try:
            result = next(waiting[0])
        except StopIteration:
            waiting.pop(0)
            continue
        if result is not None:
            results.append(result)
            waiting.append(waiting.pop(0))
    return results
