"""The hidden machine: an own plant in plain numpy and numba after docs/method/plant.md. Imports nothing of the finder or its kernel."""

import hashlib
import tempfile
from pathlib import Path

import numba

# numba's cache notices changes of a function's own file only; a folder named after all sources never runs an old machine.
_SOURCES = b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py")))
_CACHE = Path(tempfile.gettempdir()) / f"blind-truth-{hashlib.sha256(_SOURCES).hexdigest()[:16]}"
_BEFORE = numba.config.CACHE_DIR
numba.config.CACHE_DIR = str(_CACHE)

from tests.blind.truth import friction, hydraulics, link, measure, plant  # noqa: E402, F401  (compiled functions take the folder when defined)

numba.config.CACHE_DIR = _BEFORE
