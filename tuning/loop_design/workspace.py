"""Where in an arm's workspace a design is judged: the places of the paper's arm (12 to 60 in, 45 and 75 lb), on every other arm at the
same shares of its own travel and payload.

Share 0 is the shortest extension that the rig file allows, 1 the longest; payload 1 is the one the rig file believes in.
"""

from __future__ import annotations

from collections.abc import Iterable

from config.schema.rig import Rig
from tuning.variants import PRISMATIC

OVERLOAD = 5 / 3  # 75 lb where 45 lb are believed
# Extension and payload: the corners of the workspace and the places between where the link mode is damped least.
UNLOADED = ((0.0, 0.0), (0.5, 0.0), (1.0, 0.0))
LOADED = (
    (0.0, 1.0), (1 / 6, 1.0), (0.375, 1.0), (0.5, 1.0), (0.75, 1.0), (1.0, 1.0), (0.25, OVERLOAD), (7 / 12, OVERLOAD), (1.0, OVERLOAD),
)  # fmt: skip
WORKSPACE = UNLOADED + LOADED

Place = tuple[float, float]  # extension (m), payload (kg)


def extension_m(rig: Rig, share: float) -> float:
    """At this share of the travel that the rig file allows the extension."""
    low, high = rig.joints[PRISMATIC].travel
    return low + share * (high - low)


def places_in(rig: Rig, shares: Iterable[tuple[float, float]] = WORKSPACE) -> list[Place]:
    """Each place once: without a believed payload the loaded arm is the empty one."""
    assert rig.link_mode is not None
    believed_kg = rig.link_mode.payload_kg
    return list(dict.fromkeys((extension_m(rig, share), payload * believed_kg) for share, payload in shares))
