"""Where the compiled kernel is kept between runs, and the announcement when it must be compiled.

numba's own cache notices changes of a function's file but not of the files it calls into. The directory here is named after the
content of all sources, those of the effects' own laws included, so a changed valve.py never runs an old kernel. It also works where the
package itself is read-only.
"""

from __future__ import annotations

import hashlib
import os
import platform
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numba

from config.schema.effect_library import EFFECTS

TYPICAL_COMPILE_S = 10
COMPILED_ROOMS = ("memory", "physics", "kernel")  # of sim_backend: all compiled code lives there


def prepare() -> None:
    """Point numba to the cache directory of exactly these sources; where none can be written, to a new one for this process."""
    try:
        wanted = directory()
        wanted.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):  # read-only, or a user without a home
        wanted = Path(tempfile.mkdtemp(prefix="longreach-kernel-"))
    numba.config.CACHE_DIR = str(wanted)


def directory() -> Path:
    """Cache directory for these sources, this numba and this kind of processor ($CACHE_DIRECTORY of systemd, or the user's cache)."""
    base = os.environ.get("CACHE_DIRECTORY") or os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "longreach" / f"kernel-{_fingerprint()}"


def is_compiled() -> bool:
    """Whether the kernel's entry points are in the cache already."""
    return any(Path(numba.config.CACHE_DIR).rglob("kernel.advance-*.nbc"))


def announce(say: Callable[[str], None] | None = None) -> None:
    """Tell the user that the next call takes long, unless the kernel is in the cache. `say` takes one line; default: stderr."""
    if is_compiled():
        return
    line = f"compiling the simulation kernel (once, about {TYPICAL_COMPILE_S} s)…"
    if say is None:
        print(line, file=sys.stderr, flush=True)
    else:
        say(line)


def _fingerprint() -> str:
    digest = hashlib.sha256(f"{numba.__version__} {platform.python_version()} {platform.machine()}".encode())
    for source in sorted(source for room in COMPILED_ROOMS for source in (Path(__file__).parents[1] / room).glob("*.py")):
        digest.update(source.read_bytes())
    for name, effect in EFFECTS.items():
        if effect.law:
            digest.update(name.encode() + Path(effect.law.function.__code__.co_filename).read_bytes())
    return digest.hexdigest()[:16]
