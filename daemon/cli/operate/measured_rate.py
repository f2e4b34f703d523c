"""Measures a rate with the daemon itself: its processes, the rig's devices and the log, for some seconds.

Simulated devices are armed and held, so that the controller works too; real ones are only read, and their outputs stay safe.
"""

from __future__ import annotations

import tempfile
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from config.checking.check import refuse_unusable
from config.errors import DaemonError
from config.loading.identified import record_path
from config.loading.load import LoadedRig, changed_rig
from config.schema.rig import Rig
from daemon.cli.operate.private_daemon import private_daemon
from daemon.faults.benches.daemon_process import hold
from daemon.host.rate_seen import MEASURED_S, RateSeen, rate_seen
from daemon.server.protocol import Client
from recording.files.reader import read_log

# What would end the measurement; it is judged by the rig's own limits.
_PATIENT = ("loop.demand_rate=false", "loop.overruns.stop_after=1000000", "loop.overruns.fault_late=1 s")
_HOLD_LIMIT_S = 5.0


def measure(loaded: LoadedRig, rate_Hz: float | None = None, seconds: float = MEASURED_S) -> RateSeen:
    """This computer now, at the rig's rate or another one; takes `seconds` and a daemon's start.

    ConfigError where the rig cannot have the rate (its bus may be too slow), DaemonError when the daemon does not start."""
    rate_Hz = rate_Hz or loaded.rig.loop.rate_Hz
    changed = changed_rig(loaded.text, loaded.path, [f"loop.rate={rate_Hz!r} Hz", *_PATIENT, *_record(loaded)])
    refuse_unusable(changed)
    with tempfile.TemporaryDirectory(prefix="longreach-host-") as place:
        out = Path(place)
        rig = out / "rig.yaml"
        rig.write_text(changed.text)
        try:
            held, first, last, refused = _measured(rig, out, seconds, is_simulated(loaded.rig))
        except DaemonError as error:  # its words stood in a file that is gone
            parts = error.refusal
            raise DaemonError(parts.what, value=parts.value, where=loaded.path, next_step=parts.next_step) from error
        return rate_seen(_rows(out, first, last), loaded.rig.loop, rate_Hz, held, refused)


def _measured(rig: Path, out: Path, seconds: float, may_hold: bool) -> tuple[bool, int, int, tuple[str, ...]]:
    """Whether it was held, the first and the last cycle, rights that were refused."""
    with private_daemon(rig, out) as client:
        held = may_hold and _held(client)
        first = client.call("status")["cycle"]
        time.sleep(seconds)
        return held, first, client.call("status")["cycle"], _refused(client)


def is_simulated(rig: Rig) -> bool:
    """Nothing but simulated devices: no reason to be strict with the machine."""
    return all(device.driver == "sim" for device in rig.devices.values())


def _record(loaded: LoadedRig) -> list[str]:
    """A calibration record that the rig file names counts from where that file stands."""
    identified = loaded.rig.identified
    return [] if identified is None else [f"identified.record={record_path(identified.record, Path(loaded.path)).resolve()}"]


def _held(client: Client) -> bool:
    """Armed and held; False where the rig refuses, because something has to be proved first for instance."""
    with suppress(DaemonError):
        hold(client, _HOLD_LIMIT_S)
        return True
    return False


def _refused(client: Client) -> tuple[str, ...]:
    rows = client.call("checks")["checks"]
    return tuple(f"{row['name']}: {row['value']}" for row in rows if row["source"] == "host" and row["severity"] == "warning")


def _rows(out: Path, first: int, last: int) -> dict[str, Any]:
    """The cycles from `first` to `last` of every recording that was made."""
    logs = sorted((read_log(path) for path in out.glob("*.mcap")), key=lambda log: log.columns["cycle"][0])
    whole = {name: np.concatenate([log.columns[name] for log in logs]) for name in logs[0].columns}
    chosen = (whole["cycle"] >= first) & (whole["cycle"] <= last)
    return {name: values[chosen] for name, values in whole.items()}
