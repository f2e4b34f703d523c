"""The service from a wheel alone: no checkout, no package index; `longreach service install` in the environment that holds the wheel."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest

from tests.support.system.built_wheel import built_wheel, environment_with
from tests.systemd.longreach_service import UNIT, Service
from tests.systemd.nspawn_machine import Machine, why_not

pytestmark = [pytest.mark.slow, pytest.mark.clock, pytest.mark.timeout(300)]
LONGREACH = ("/srv/venv/bin/python", "-I", "-m", "daemon.cli.main")


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Machine]:
    """Instead of the checkout it sees an empty folder."""
    if reason := why_not():
        pytest.skip(reason)
    folder = tmp_path_factory.mktemp("wheel")
    environment = environment_with(built_wheel(folder), folder / "environment").parents[1]
    nothing = folder / "nothing"
    nothing.mkdir()
    with Machine(tmp_path_factory.mktemp("machine"), nothing, environment) as machine:
        yield machine


def test_it_is_installed_runs_and_is_removed(machine: Machine) -> None:
    said = machine.run(*LONGREACH, "service", "install", check=True, limit_s=200).stdout
    assert "systemctl enable --now longreachd" in said
    service = Service(machine)
    assert machine.run("systemd-analyze", "verify", f"/etc/systemd/system/{UNIT}").stderr == ""
    service.up()
    service.hold()
    run = service.call("start", maneuver={"name": "jog"}, countdown_s=0.0)["run"]
    assert service.call("wait", run=run, timeout_s=30.0)["validity"] == "valid"
    assert service.recording().parent == service.logs
    assert service.show("FragmentPath") == f"/etc/systemd/system/{UNIT}"
    version = machine.run("/usr/local/bin/longreach", "version", "--json", check=True).stdout
    assert json.loads(version)["software_commit"] == json.loads(machine.run(*LONGREACH, "version", "--json").stdout)["software_commit"]

    refused = machine.run(*LONGREACH, "service", "uninstall")
    assert refused.returncode == 1
    assert "systemctl stop longreachd" in refused.stderr
    service.systemctl("stop", UNIT)
    machine.run("/usr/local/bin/longreach", "service", "uninstall", check=True)  # by the copy that is removed
    assert not machine.path("/opt/longreach").exists()
    assert service.show("LoadState") == "not-found"
    assert machine.path("/etc/longreach/rig.yaml").exists()


def test_without_root_it_says_what_to_type(machine: Machine) -> None:
    answer = machine.run("setpriv", "--reuid", "nobody", "--clear-groups", *LONGREACH, "service", "install")
    assert answer.returncode == 1
    assert "sudo /srv/venv/bin/longreach service install" in answer.stderr
    assert "--destdir DIR" in answer.stderr
