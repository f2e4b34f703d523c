"""A plug-in that `new-driver` has just written: its own test passes, and registry, check, overrides and reference know it at once."""

from __future__ import annotations

import datetime
import os
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from config.checking.check import check_rig
from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text
from config.options.plug_ins import installed
from daemon.cli.main import main
from drivers import registry

CHECKOUT = Path(__file__).parents[2]
TEXT = load_rig("force_axis").text + "\n"
TODAY = datetime.date(2026, 1, 1)


@pytest.fixture
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "longreach-gauge"
    assert main(["new-driver", "gauge", "--out", str(folder)]) == 0
    return folder


@pytest.fixture
def plug_in(package: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The package as pip would install it: on the path, its entry points beside it."""
    groups = tomllib.loads((package / "pyproject.toml").read_text())["project"]["entry-points"]
    information = package / "longreach_gauge-0.1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: longreach-gauge\nVersion: 0.1.0\n")
    lines = [f"[{group}]\n" + "".join(f"{name} = {place}\n" for name, place in points.items()) for group, points in groups.items()]
    (information / "entry_points.txt").write_text("\n".join(lines))
    monkeypatch.syspath_prepend(str(package))
    installed.cache_clear()
    yield package
    installed.cache_clear()
    sys.modules.pop("longreach_gauge", None)


def rig_with(options: str, driver: str = "gauge") -> LoadedRig:
    text = TEXT.replace("\ndevices:\n", f"\ndevices:\n  extra: {{driver: {driver}, options: {options}}}\n", 1)
    return LoadedRig(rig_from_text(text, "bench.yaml"), text, "bench.yaml")


def complaints(loaded: LoadedRig) -> list[str]:
    return [finding.text for finding in check_rig(loaded, TODAY) if finding.level != "ok" and "extra" in finding.text]


@pytest.mark.slow
@pytest.mark.parametrize("around", ["", '[tool.pytest.ini_options]\naddopts = "--import-mode importlib"\n'], ids=["outside", "inside"])
def test_its_contract_test_passes_outside_and_inside_a_checkout(package: Path, around: str) -> None:
    """Before it is installed, too. `around`: settings of pytest in the folder above, as this checkout has them."""
    if around:
        package.with_name("pyproject.toml").write_text(around)
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", package.name]
    run = subprocess.run(command, cwd=package.parent, env=environment, capture_output=True, text=True, timeout=120, check=False)
    assert run.returncode == 0, run.stdout
    assert " passed" in run.stdout
    assert "failed" not in run.stdout


def test_check_knows_its_options_and_channels(plug_in: Path) -> None:
    assert complaints(rig_with("{port: /dev/x}")) == []
    (told,) = complaints(rig_with("{prot: x}"))
    assert "devices.extra.options.prot is not a key here: nearest is 'port'" in told
    assert told.startswith("bench.yaml:")
    (told,) = complaints(rig_with("{answer_timeout: 2 s}"))
    assert "answer_timeout is out of range: 2 s (limit: 0.001 to 1 s)" in told


def test_the_registry_makes_it_and_overrides_reach_it(plug_in: Path) -> None:
    loaded = rig_with("{}")
    rig = rig_from_text(apply_overrides(loaded.text, ["devices.extra.options.unit=7"]))
    assert rig.devices["extra"].options == {"unit": 7}
    driver = registry.create("extra", rig.devices["extra"], rig, lockstep=False)
    assert (driver.inputs, driver.outputs) == (("voltage",), ("command",))


def test_its_reference_is_printed(plug_in: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["device", "options", "gauge"]) == 0
    page = capsys.readouterr().out
    assert "| `answer_timeout` | no answer within this time is a failure | s | number, 0.001 to 1 | 0.01 |" in page
    assert "| `command` | output | voltage to the valve | V | -10 to 10 |" in page


def test_a_driver_that_declares_nothing_is_pointed_out(plug_in: Path) -> None:
    points = plug_in / "longreach_gauge-0.1.0.dist-info" / "entry_points.txt"
    points.write_text("[longreach.drivers]\ngauge = longreach_gauge:create\n")
    installed.cache_clear()
    (told,) = complaints(rig_with("{anything: goes}"))
    assert "the driver 'gauge' declares no options (entry-point group longreach.driver_options)" in told


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("def input_channels(self, rig):\n        return self.chanels", "input_channels() of the driver 'gauge' fails: AttributeError"),
        ("def warnings(self):\n        yield 1 / 0", "warnings() of the driver 'gauge' fails: ZeroDivisionError: division by zero"),
        (
            "def model_post_init(self, _):\n        raise KeyError('port')",
            "the class of options of the driver 'gauge' fails: KeyError: 'port'",
        ),
        (
            "def input_channels(self, rig):\n        return ['voltage']",
            "input_channels() of the driver 'gauge' must return a mapping of names to Channel: got ['voltage']",
        ),
        (
            "def output_channels(self, rig):\n        return {'command': 'V'}",
            "output_channels() of the driver 'gauge' must return a mapping of names to Channel: got {'command': 'V'}",
        ),
        ("def output_channels(self, rig):\n        pass", "output_channels() of the driver 'gauge' must return a mapping"),
        ("def must_prove(self):\n        raise SystemExit(3)", "must_prove() of the driver 'gauge' fails: SystemExit: 3"),
        ("def warnings(self):\n        return ['port']", "warnings() of the driver 'gauge' must return pairs"),
        (
            'span_s: float = quantity("s", "too long", 5.0, high=1)',
            "the option 'span' of the driver 'gauge' has a default that it refuses: 5.0 s",
        ),
        (
            'span: float = quantity("sec2", "no unit", 1.0)',
            "the option 'span' of the driver 'gauge' is declared in an unknown unit: 'sec2'",
        ),
    ],
)
def test_code_of_an_options_class_that_fails_is_told_at_its_place(plug_in: Path, fault: str, message: str) -> None:
    module, following = plug_in / "longreach_gauge.py", "class Memory:"
    module.write_text(module.read_text().replace(f"\n\n{following}", f"\n    {fault}\n\n\n{following}", 1))
    told = [text for text in complaints(rig_with("{}")) if message in text]
    assert told
    assert told[0].startswith("bench.yaml:")
    first = module.read_text().split("\n").index(f"    {fault}".split("\n")[0]) + 1
    assert any(f"end it at {module}:{line}" in told[0] for line in (first, first + 1))


def test_an_address_that_is_none_is_told_at_its_place(plug_in: Path) -> None:
    module = plug_in / "longreach_gauge.py"
    module.write_text(module.read_text().replace('return Address(("gauge", self.port), self.unit, "unit")', "return self.port", 1))
    (told,) = complaints(rig_with("{}"))
    assert "address() of the driver 'gauge' must return an Address or None: got 'memory'. Mend it at" in told


def test_a_module_that_ends_the_command_on_import_is_told_at_its_place(plug_in: Path) -> None:
    module = plug_in / "longreach_gauge.py"
    module.write_text(module.read_text().replace("LARGEST_V = 10.0", "raise SystemExit(3)", 1))
    (told,) = complaints(rig_with("{}"))
    line = module.read_text().split("\n").index("raise SystemExit(3)") + 1
    assert (
        f"the driver 'gauge' cannot be loaded: SystemExit: 3. Its entry point is 'longreach_gauge:Options': mend it at {module}:{line}."
        in told
    )


def test_a_driver_whose_factory_is_missing_is_told_before_the_daemon_starts(plug_in: Path) -> None:
    points = plug_in / "longreach_gauge-0.1.0.dist-info" / "entry_points.txt"
    points.write_text(points.read_text().replace(":create", ":creat"))
    installed.cache_clear()
    (told,) = complaints(rig_with("{}"))
    assert "the driver 'gauge' cannot be loaded: AttributeError" in told
    assert "Its entry point is 'longreach_gauge:creat'" in told


@pytest.mark.parametrize(("name", "message"), [("Gauge-1", "lower-case"), ("modbus", "is installed")])
def test_a_name_that_cannot_be_used_writes_nothing(name: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new-driver", name, "--out", str(tmp_path / "x")]) == 1
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
