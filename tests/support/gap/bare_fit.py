"""A fitted set that is no more than its names and its ln Z."""

from __future__ import annotations

from collections.abc import Set
from types import SimpleNamespace
from typing import Any

import numpy as np

WINDOWS = 40


def bare_fit(labels: Set[str], log_z: float, windows: int = WINDOWS) -> Any:
    """What it has beside a ln Z of 0 comes from all windows alike, so that no bootstrap moves it."""
    return SimpleNamespace(labels=frozenset(labels), suspects=tuple(labels), log_z=log_z, windows=np.full(windows, log_z / windows))
