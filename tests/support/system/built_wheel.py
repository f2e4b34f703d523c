"""The wheel of this checkout, and an environment that holds nothing but it and the libraries that it declares."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

CHECKOUT = Path(__file__).parents[3]
PIP = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]


def built_wheel(folder: Path) -> Path:
    """From the files that git knows, as they are now, in `folder`."""
    archive, source = folder / "source.tar", folder / "source"
    tracked = subprocess.run(["git", "ls-files", "-z"], cwd=CHECKOUT, capture_output=True, check=True).stdout
    there = b"\0".join(name for name in tracked.split(b"\0") if name and (CHECKOUT / os.fsdecode(name)).is_file())
    subprocess.run(["tar", "--null", "-T", "-", "-cf", str(archive)], cwd=CHECKOUT, input=there, check=True)
    source.mkdir()
    subprocess.run(["tar", "-C", str(source), "-xf", str(archive)], check=True)
    subprocess.run([*PIP, "wheel", "--no-deps", "--no-build-isolation", "-w", str(folder), str(source)], check=True)
    (wheel,) = folder.glob("longreach-*.whl")
    return wheel


def environment_with(wheel: Path, environment: Path) -> Path:
    """Its interpreter. Libraries are copied from this one, as `daemon/systemd/install.sh --from-venv` does: no package index is needed."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(environment)], check=True)
    python = environment / "bin" / "python"
    ours, theirs = (_purelib(each) for each in (sys.executable, str(python)))
    listed = subprocess.run([sys.executable, str(CHECKOUT / "daemon/systemd/runtime_files.py")], capture_output=True, check=True).stdout
    subprocess.run(["bash", "-c", f"tar -C {ours} -T - -cf - | tar -C {theirs} -xf -"], input=listed, check=True)
    subprocess.run([*PIP, "--python", str(python), "install", "--no-deps", "--no-index", str(wheel)], check=True)
    return python


def _purelib(python: str) -> str:
    words = [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
