from __future__ import annotations

import pytest

from config.load import find, load_rig
from config.rig import Rig


@pytest.fixture(scope="session")
def rig() -> Rig:
    return load_rig(find("rigs", "ornl_testbed")).rig
