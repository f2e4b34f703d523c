"""A twin that stood still: the plant moves by every SYNC that came meanwhile, and the devices answer the newest."""

from __future__ import annotations

import pytest

from sim_backend.plant import SimulatedRig
from sim_backend.twin.assembly import bench
from sim_backend.twin.bench import SYNC_ID
from sim_backend.twin.can.can_port import Frame
from tests.support.sim_backend.twin_rig import twin_rig

MS = 1_000_000
ENCODER = 3


def test_only_the_newest_of_late_syncs_is_answered() -> None:
    rig, sent = twin_rig("late", 1), []
    made = bench(rig, SimulatedRig(rig), lambda cob_id, data: sent.append(cob_id))
    made.start(0)
    made.on_frame(0, bytes([1, 0]), 0)
    made.on_frames([Frame(SYNC_ID, b"", 1 * MS)], 1 * MS)
    sent.clear()
    made.on_frames([Frame(SYNC_ID, b"", number * MS) for number in range(2, 12)], 11 * MS + MS // 2)
    assert made.feed.plant.time_s == pytest.approx(11 * made.feed.period_s)
    assert sent.count(0x180 + ENCODER) == 1
    assert made.unanswered == 9
    assert made.clock.caught_up == 0
