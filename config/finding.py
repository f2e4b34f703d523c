"""What a check says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Level = Literal["ok", "warning", "error"]


@dataclass(frozen=True, slots=True)
class Finding:
    """One statement about a rig. `error`: the rig cannot work as written; `warning`: it works, but perhaps not as meant."""

    level: Level
    text: str
