"""LinuxCNC's servo thread at 1 kHz without machine or screen: every period, as its own components measure and sample it.

Needs root, `apt-get install linuxcnc-uspace` and a C compiler. On a virtual machine LinuxCNC falls back to ordinary scheduling because
iopl() or setrlimit() are refused; it needs neither to run a thread, so they are answered by a stub.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from itertools import accumulate
from pathlib import Path

MISSING = "LinuxCNC: not installed or not runnable here (root, apt-get install linuxcnc-uspace gcc)"
_STUB = "\n".join(f"int {call}(long a, long b, long c) {{ return 0; }}" for call in ("iopl", "ioperm", "setrlimit", "setrlimit64"))
_HAL = """
loadrt threads name1=servo period1={period_ns}
loadrt timedelta count=1
loadrt sampler cfg=s depth=100000
addf timedelta.0 servo
addf sampler.0 servo
net d timedelta.0.out => sampler.0.pin.0
start
loadusr -w halsampler -n {count} {out}
"""
_START_S = 600.0  # of its helpers, which have no priority: a starved machine took more than a minute
_USER = 65534  # it wants one beside root
_REALTIME = "Using POSIX realtime"


def is_here() -> bool:
    return os.geteuid() == 0 and bool(shutil.which("halrun")) and bool(_compiler())


def servo_thread(seconds: float, period_ns: int) -> list[float]:
    """When each cycle began, in us: the running sum of its periods. RuntimeError where it gets no real time."""
    count = round(seconds * 1e9 / period_ns)
    with tempfile.TemporaryDirectory(prefix="longreach-linuxcnc-") as folder:
        place = Path(folder)
        place.chmod(0o777)
        (place / "stub.c").write_text(_STUB)
        subprocess.run([_compiler(), "-shared", "-fPIC", "-o", place / "stub.so", place / "stub.c"], check=True)
        (place / "servo.hal").write_text(_HAL.format(period_ns=period_ns, count=count + 2, out=place / "periods.txt"))
        ours = {"LD_PRELOAD": f"{place}/stub.so", "RTAPI_UID": str(_USER), "RTAPI_FIFO_PATH": f"{place}/fifo", "HOME": folder}
        environment = {**os.environ, **ours, "LINUXCNC_FORCE_REALTIME": "1"}
        done = subprocess.run(
            ["halrun", place / "servo.hal"], env=environment, capture_output=True, text=True, check=True, timeout=seconds + _START_S
        )
        if _REALTIME not in done.stdout + done.stderr:
            raise RuntimeError(f"LinuxCNC runs without real time: {(done.stdout + done.stderr).strip()[:500]}")
        periods_ns = [int(line) for line in (place / "periods.txt").read_text().split()][2:]  # the first two have no cycle before them
    return [1e-3 * began for began in accumulate(periods_ns, initial=0)]


def _compiler() -> str:
    return shutil.which("cc") or shutil.which("gcc") or ""
