"""One machine for all tests of the service: booted, longreach installed the way an operator does it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.systemd.longreach_service import Service
from tests.systemd.nspawn_machine import Machine, why_not

CHECKOUT = Path(__file__).resolve().parents[2]
VENV = Path(sys.prefix)


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Machine]:
    reason = why_not()
    if reason:
        pytest.skip(reason)
    with Machine(tmp_path_factory.mktemp("machine"), CHECKOUT, VENV) as machine:
        yield machine


@pytest.fixture(scope="module")
def installed(machine: Machine) -> Service:
    machine.run("make", "-C", "/srv/longreach", "install", "FROM_VENV=/srv/venv", check=True, limit_s=200)
    return Service(machine)


@pytest.fixture
def service(installed: Service) -> Service:
    installed.up()
    return installed
