"""A rig whose devices nobody could reach has no twin: it would wait for ever and serve nobody."""

from __future__ import annotations

import pytest

from config.errors import ConfigError
from config.loading.load import load_rig
from sim_backend.twin.process import Twin


def test_a_rig_without_a_device_on_a_bus_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"no device of the rig is on a CAN bus or a Modbus line: force_axis"):
        Twin(load_rig("force_axis").rig)
