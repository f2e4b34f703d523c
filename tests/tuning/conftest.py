from __future__ import annotations

import pytest

from config.loading.load import find, load_rig
from config.schema.rig import Rig


@pytest.fixture(scope="session")
def rig() -> Rig:
    return load_rig(find("rigs", "ornl_testbed")).rig
