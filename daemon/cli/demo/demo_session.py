"""One run of the demo through a real daemon on the wall clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from config.errors import DaemonError
from daemon.cli.operate.motion_commands import wait_for
from daemon.cli.operate.private_daemon import private_daemon
from daemon.server.protocol import Client
from recording.files.recordings import asked

_MODE_LIMIT_S = 10.0

Show = Callable[[dict[str, Any]], None]


def wall_clock_run(rig: Path, request: Mapping[str, Any], out: Path, show: Show) -> Path:
    """A request in a daemon of its own, so that no run starts with what the one before left swinging. Returns its log.

    Raises DaemonError when the daemon does not start, does not arm in time, or the run does not end valid; refusals as `start`.
    """
    with private_daemon(rig, out) as client:
        return _one_run(client, request, show)


def _one_run(client: Client, request: Mapping[str, Any], show: Show) -> Path:
    """Release the e-stop, which starts latched; arm, run, disarm: arming begins a new recording, so the run has a log of its own."""
    client.call("reset")
    client.call("arm")
    _until_mode(client, "holding", show)
    run = client.call("start", **request)
    result = wait_for(client, run["run"], show)
    log = Path(client.call("status")["log"]["path"])
    client.call("disarm")
    if result["validity"] != "valid":
        raise DaemonError(
            "a demo run is not valid",
            value=str(result.get("reason", "")).rstrip("."),
            where=str(log),
            next_step=f"See {asked('info', log)}.",
        )
    _until_mode(client, "disarmed", show)
    return log


def _until_mode(client: Client, mode: str, show: Show) -> None:
    """Wait for a mode; the limit is generous because arming includes settling."""
    limit = time.monotonic() + _MODE_LIMIT_S
    while time.monotonic() < limit:
        status = client.call("status")
        show(status)
        if status["mode"] == mode:
            return
        if status["mode"] == "fault":
            break
        time.sleep(0.05)
    fault = status.get("fault")
    raise DaemonError(
        "the daemon did not change its mode",
        value=f"{status['mode']}: {fault['text'].rstrip('.')}" if fault else status["mode"],
        limit=f"{mode} within {_MODE_LIMIT_S:g} s",
        next_step="See whether other work keeps this computer busy: `longreach host`.",
    )
