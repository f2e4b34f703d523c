"""The shipped testbed and the paper's line."""

from __future__ import annotations

from typing import Any

import pytest
from asking import shipped

from config.load import find, load_rig
from config.rig import Rig


@pytest.fixture(scope="session")
def rig() -> Rig:
    return load_rig(find("rigs", "ornl_testbed")).rig


@pytest.fixture(scope="session")
def paper_y30() -> dict[str, Any]:
    return shipped("paper_line_y30")
