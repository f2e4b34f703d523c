from __future__ import annotations

from importlib import import_module
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from config import reference
from config.checking.check import refuse_unusable
from config.errors import ConfigError, DriverError
from config.loading.load import LoadedRig, load_rig, rig_from_text
from config.options.driver_options import SHIPPED, ShippedDriver, factories
from config.options.plug_ins import DRIVERS
from config.schema.rig import Device
from drivers import registry
from drivers.driver_template import driver_files

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
    broken = EntryPoint("broken", "no_such_module_anywhere:create", DRIVERS)
    monkeypatch.setattr(registry, "factories", lambda: {"broken": broken})
    with pytest.raises(DriverError, match=r"cannot be loaded.*no_such_module_anywhere"):
        registry.create("x", Device(driver="broken"), RIG, lockstep=True)


def test_a_driver_to_ship_is_one_file_and_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the loader with its options, in the reference and in the registry."""
    (tmp_path / "longreach_shelf.py").write_text(driver_files("shelf")["longreach_shelf.py"])
    monkeypatch.syspath_prepend(tmp_path)
    options = import_module("longreach_shelf").Options
    monkeypatch.setitem(SHIPPED, "shelf", ShippedDriver(options, "longreach_shelf:create"))

    def rig_with(option: str) -> LoadedRig:
        text = load_rig("ornl_testbed").text.replace("\ndevices:\n", f"\ndevices:\n  shelf: {{driver: shelf, options: {{{option}}}}}\n")
        return LoadedRig(rig_from_text(text, "rig.yaml"), text, "rig.yaml")

    good = rig_with("port: attic")
    refuse_unusable(good)
    assert type(registry.create("shelf", good.rig.devices["shelf"], good.rig, lockstep=True)).__module__ == "longreach_shelf"
    with pytest.raises(ConfigError, match=r"prot.*'port'"):
        refuse_unusable(rig_with("prot: attic"))
    assert "# `driver: shelf`" in reference.pages()["drivers.md"]
    assert "shelf" in registry.known_drivers()


@pytest.mark.parametrize("name", sorted(SHIPPED))
def test_every_shipped_factory_can_be_imported(name: str) -> None:
    assert callable(factories()[name].load())
