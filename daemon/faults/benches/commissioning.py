"""From a daemon that has just started to an arm that holds its position: what an operator does, with the twin as the rig.

The pressure is taken off, the devices prove their safe state, the pressure comes back, and the rig is armed.
"""

from __future__ import annotations

from contextlib import suppress

from config.errors import DaemonError
from daemon.faults.benches.daemon_process import hold, wait_for
from daemon.server.protocol import Client
from sim_backend.twin.control_socket import TwinControl

PROOF_LIMIT_S = 20.0  # with second tries: a computer that pauses during a proof makes it fail


def commission(client: Client, twin: TwinControl) -> None:
    """Returns when the arm is held. DaemonError when a device does not prove its safe state or arming is refused for too long."""
    client.call("reset")
    twin.inject("plant", "supply_pressure", 0.0)
    try:
        wait_for(lambda: _proven(client), PROOF_LIMIT_S)
    finally:
        twin.clear("plant")
    hold(client)


def _proven(client: Client) -> bool:
    """Refused until the gauges show that the pressure is off."""
    if client.call("status")["mode"] == "fault":
        client.call("reset")
    with suppress(DaemonError):
        return bool(client.call("prove", countdown_s=0.0)["good"])
    return False
