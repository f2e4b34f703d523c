"""A throw-away machine with a real systemd as its first process, driven from the test."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

HERE = Path(__file__).parent
PR_SET_PDEATHSIG = 1


def why_not() -> str:
    """The reason why this host cannot boot one; empty when it can."""
    if os.geteuid() != 0:
        return "booting a systemd needs root"
    missing = [tool for tool in ("systemd-nspawn", "nsenter", "unshare") if shutil.which(tool) is None]
    return f"not installed: {', '.join(missing)} (Debian: systemd-container)" if missing else ""


def eventually(what: str, condition: Callable[[], bool], limit_s: float) -> float:
    """Wait for a condition; the seconds it took."""
    started = time.monotonic()
    while not condition():
        assert time.monotonic() - started < limit_s, f"{what}: not within {limit_s} s"
        time.sleep(0.02)
    return time.monotonic() - started


class Machine:
    """Use in a with statement. `source` and `venv` are seen as /srv/longreach and /srv/venv."""

    def __init__(self, scratch: Path, source: Path, venv: Path) -> None:
        self._scratch = scratch
        self.leader = ""
        self._arguments = [str(HERE / "boot.sh"), f"longreach-test-{os.getpid()}", str(scratch), str(source), str(venv)]

    def __enter__(self) -> Machine:
        self.console = self._scratch / "console"
        with self.console.open("wb") as output:
            self._boot = subprocess.Popen(self._arguments, stdin=subprocess.DEVNULL, stdout=output, stderr=output, preexec_fn=_die_with_us)
        try:
            eventually("systemd-nspawn runs", (self._scratch / "pid").exists, 10)
            self._nspawn = (self._scratch / "pid").read_text().strip()
            eventually("the machine has a first process", lambda: bool(self._find_leader()), 10)
            self.leader = self._find_leader()
            eventually("the machine is up", self._is_up, 60)
        except AssertionError as error:
            self.__exit__()
            raise AssertionError(f"{error}\n{self.console.read_text(errors='replace')[-4000:]}") from None
        return self

    def _find_leader(self) -> str:
        """The machine's process 1, as numbered here; nspawn has other short-lived children while it sets up."""
        for child in Path(f"/proc/{self._nspawn}/task/{self._nspawn}/children").read_text().split():
            with suppress(FileNotFoundError):
                if re.search(r"^NSpid:.*\t1$", Path(f"/proc/{child}/status").read_text(), re.MULTILINE):
                    return child
        return ""

    def _is_up(self) -> bool:
        return self.run("systemctl", "is-system-running").stdout.strip() in ("running", "degraded")

    def __exit__(self, *error: object) -> None:
        """Power off in order, then by force; boot.sh takes the control groups away."""
        if self.leader:
            with suppress(ProcessLookupError):
                os.kill(int(self.leader), signal.SIGRTMIN + 4)
        try:
            self._boot.wait(timeout=20)
        except subprocess.TimeoutExpired:
            self._boot.terminate()
            self._boot.wait(timeout=20)

    def run(self, *command: str, check: bool = False, limit_s: float = 60) -> subprocess.CompletedProcess[str]:
        """A command inside, as root; with `check` its output when it fails."""
        inside = ["nsenter", "-t", self.leader, "-m", "-u", "-i", "-n", "-p", "-C", "--", *command]
        clean = {"PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "LC_ALL": "C.UTF-8"}
        done = subprocess.run(inside, capture_output=True, text=True, timeout=limit_s, check=False, env=clean, stdin=subprocess.DEVNULL)
        if check and done.returncode != 0:
            raise AssertionError(f"{' '.join(command)}: exit status {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
        return done

    def path(self, inside: str) -> Path:
        """How a file of the machine is reached from here."""
        return Path(f"/proc/{self.leader}/root{inside}")


def _die_with_us() -> None:
    """A killed test run takes its machine with it."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, int(signal.SIGTERM), 0, 0, 0)
