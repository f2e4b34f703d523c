from __future__ import annotations

from importlib.metadata import EntryPoint

import pytest

from config.errors import DriverError
from config.load import load_rig
from config.rig import Device
from drivers import registry

RIG = load_rig("ornl_testbed").rig


def test_our_driver_is_found_by_name() -> None:
    assert "sim" in registry.known_drivers()
    driver = registry.create("plant", RIG.devices["plant"], RIG, lockstep=True)
    assert driver.name == "plant"


def test_an_unknown_driver_is_told_with_the_known_and_the_nearest() -> None:
    with pytest.raises(DriverError) as caught:
        registry.create("plant", Device(driver="sym"), RIG, lockstep=True)
    text = str(caught.value)
    assert "devices.plant.driver" in text
    assert "'sim'" in text
    assert "limit: " in text


def test_a_plug_in_that_cannot_be_imported_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    broken = EntryPoint("broken", "no_such_module_anywhere:create", registry.GROUP)
    monkeypatch.setattr(registry, "_installed", lambda: {"broken": broken})
    with pytest.raises(DriverError, match=r"cannot be loaded.*no_such_module_anywhere"):
        registry.create("x", Device(driver="broken"), RIG, lockstep=True)
