"""What a log says about the computer and the software that made it."""

from __future__ import annotations

import getpass
import os
import platform
import socket
import subprocess
from functools import cache
from importlib.metadata import version
from pathlib import Path

COMMIT_OF_INSTALLATION = Path(__file__).parents[1] / "commit.txt"
CHECKOUT = Path(__file__).parents[2]


@cache
def software() -> dict[str, str]:
    return {"software_version": version("longreach"), "software_commit": _commit()}


def host() -> dict[str, str]:
    """Facts that decide how well a loop keeps time; "unknown" where the system does not say."""
    kernel = platform.release()
    return {
        "host_name": platform.node(),
        "host_kernel": f"{platform.system()} {kernel} {platform.version()}",
        "host_preempt_rt": "yes" if _text("/sys/kernel/realtime") == "1" or "PREEMPT_RT" in platform.version() else "no",
        "host_governor": _text("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"),
        "host_isolated_cpus": _text("/sys/devices/system/cpu/isolated") or "none",
        "host_cpu": next((line.partition(":")[2].strip() for line in _lines("/proc/cpuinfo") if line.startswith("model name")), "unknown"),
        "host_cpus": str(os.cpu_count()),
        "host_python": platform.python_version(),
    }


def user_and_host() -> str:
    """Who calls a program and where, for records that name who made them."""
    return f"{getpass.getuser()}@{socket.gethostname()}"


def _commit() -> str:
    """The commit of this checkout, with + when files differ from it, or what was written down when a wheel was built; else "unknown"."""
    if COMMIT_OF_INSTALLATION.exists():
        return _text(str(COMMIT_OF_INSTALLATION))
    if not (CHECKOUT / "pyproject.toml").exists():  # an environment in somebody else's checkout
        return "unknown"
    command = ["git", "-C", str(CHECKOUT), "describe", "--always", "--abbrev=12", "--dirty=+", "--exclude=*"]
    try:
        found = subprocess.run(command, capture_output=True, text=True, timeout=5, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return "unknown"
    return found.stdout.strip() or "unknown"


def _text(path: str) -> str:
    try:
        return Path(path).read_text().strip()
    except OSError:
        return "unknown"


def _lines(path: str) -> list[str]:
    return _text(path).splitlines()
