"""The testbed with the plain servo of 1997 (proportional, no end-point feedback), whose answers are known in closed form; the line."""

from __future__ import annotations

from math import degrees
from typing import Any

import pytest

from config.loading.load import find, load_rig
from config.schema.rig import Rig
from tests.support.servo_control.testbed_runs import shipped


@pytest.fixture(scope="session")
def rig() -> Rig:
    shipped_rig = load_rig(find("rigs", "ornl_testbed")).rig
    changes = {"gain": degrees(0.35), "acceleration_feedforward": 0.0, "dither_V": 0.0, "oil_compensation": None, "link_notch": None}
    plain = shipped_rig.servo["rotary"].model_copy(update=changes)
    return shipped_rig.model_copy(update={"servo": {**shipped_rig.servo, "rotary": plain}, "end_point": None})


@pytest.fixture(scope="session")
def paper_y30() -> dict[str, Any]:
    return shipped("paper_line_y30")
