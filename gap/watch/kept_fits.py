"""Fits of single logs, each made once: one small file a log, named after the hash of the log, the rig file and the code that fits.

A refusal is kept as well. A file that cannot be read counts as none.
"""

from __future__ import annotations

import hashlib
import json
from functools import cache
from pathlib import Path

import numpy as np

from config.errors import LogError, LongreachError
from config.loading.load import LoadedRig
from config.schema.effect_library import library_folders
from config.whole_file import write_whole
from gap.data.log_parts import load_parts
from gap.watch.dated_logs import Unusable
from gap.watch.log_fit import LogFit, fit_log

_CHECKOUT = Path(__file__).parents[2]
# What a fit depends on; pages and pictures do not change it.
_CODE = ("config", "recording", "sim_backend", "gap/data", "gap/fitting", "gap/settings.py", "gap/suspects",
         "gap/evidence/score/changed.py", "gap/evidence/deciding_numbers.py", "gap/watch/log_fit.py", "gap/watch/watched.py")  # fmt: skip


def key_of(path: Path, loaded: LoadedRig) -> str:
    """Hash of everything that a fit of this log depends on."""
    own = hashlib.sha256(path.read_bytes()).hexdigest()
    return hashlib.sha256(f"{own} {hashlib.sha256(loaded.text.encode()).hexdigest()} {source_version()}".encode()).hexdigest()[:32]


@cache
def source_version() -> str:
    """Hash of the code that fits a log, effects of other libraries included."""
    said = hashlib.sha256()
    for at in [*(_CHECKOUT / place for place in _CODE), *library_folders()]:
        for path in [at] if at.is_file() else sorted(at.rglob("*.py")):
            said.update(path.read_bytes())
    return said.hexdigest()


def kept(folder: Path, key: str, log: Path) -> LogFit | Unusable | None:
    """What was found before; None where nothing was."""
    try:
        content = json.loads((folder / f"{key}.json").read_text())
        return Unusable(log, content["why"], content["next_step"]) if "why" in content else LogFit.of(content)
    except (OSError, ValueError, KeyError, TypeError):
        return None


def fitted(folder: Path, key: str, log: Path, loaded: LoadedRig, workers: int) -> LogFit | Unusable:
    """Fit a log, and keep what comes of it."""
    try:
        found: LogFit | Unusable = fit_log(loaded, load_parts([log], loaded.rig), workers)
    except LongreachError as error:
        found = Unusable.of(log, error)
    except np.linalg.LinAlgError:
        found = Unusable.of(log, LogError("its fit has no solution", next_step="Nothing about the plant can be told from this log."))
    content = {"why": found.why, "next_step": found.next_step} if isinstance(found, Unusable) else found.as_dict()
    write_whole(folder / f"{key}.json", json.dumps({"log": log.name, **content}, indent=1) + "\n")
    return found
