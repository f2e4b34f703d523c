"""The SocketCAN path of the CANopen drivers, in a user-mode Linux that has CAN: the drivers' own tests, with vcan for the virtual bus."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
CHECKOUT = HERE.parents[1]
DRIVER_TESTS = tuple(f"tests/drivers/canopen/test_{name}.py" for name in ("contract", "encoder", "valve", "io"))
LIMIT_S = 240
# Its kernel keeps the SSE registers of a process that has to wait, no wider ones (without_xstate.py): nothing there may use those.
SSE_ALONE = {
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX_Fast_Unaligned_Load,-AVX2,-AVX512F,-AVX512VL",
    "NPY_DISABLE_CPU_FEATURES": "AVX2,FMA3,AVX512F,AVX512_SKX",
    "NUMBA_CPU_NAME": "nehalem",
    "OPENBLAS_CORETYPE": "Nehalem",
}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.clock,
    pytest.mark.timeout(LIMIT_S + 30),
    pytest.mark.skipif(shutil.which("linux.uml") is None, reason="not installed: linux.uml (Debian: user-mode-linux)"),
    pytest.mark.skipif(shutil.which("insmod") is None, reason="not installed: insmod (Debian: kmod)"),
    pytest.mark.skipif(CHECKOUT.is_relative_to("/tmp"), reason="the checkout is below /tmp, which the user-mode Linux covers with its own"),
]


def in_user_mode_linux(scratch: Path, *tests: str) -> str:
    """The console of a user-mode Linux that ran these tests."""
    start = ["nice", "-n", "-10", sys.executable, str(HERE / "without_xstate.py")]
    kernel = ["linux.uml", "mem=768M", "con=null", "con0=fd:0,fd:1", "quiet", f"uml_dir={scratch}"]
    root = ["root=/dev/root", "rootfstype=hostfs", "rootflags=/", "ro", f"init={HERE / 'uml_init.sh'}"]
    handed_over = {"CHECKOUT": CHECKOUT, "PYTHON": sys.executable, "TESTS": ",".join(tests), **SSE_ALONE}
    command = [*start, *kernel, *root, *(f"{name}={value}" for name, value in handed_over.items())]
    pipe = subprocess.PIPE
    machine = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=pipe, stderr=subprocess.STDOUT, start_new_session=True)
    try:
        return machine.communicate(timeout=LIMIT_S)[0].decode(errors="replace")
    finally:
        if machine.poll() is None:
            os.killpg(machine.pid, signal.SIGKILL)


def test_drivers_on_socketcan(tmp_path: Path) -> None:
    console = in_user_mode_linux(tmp_path, "tests/systemd/vcan_checks.py", *DRIVER_TESTS)
    assert re.search(r"attempt \d: exit status 0", console), console[-6000:]
    first = re.search(r"(\d+) passed", console)
    assert first is not None
    assert int(first[1]) >= 100  # the greater part at the first attempt
