"""A lockstep rig with a simple device, for tests of the loop."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from config.loading.load import load_rig
from daemon.lockstep import LockstepRig
from tests.support.daemon.simple_device import SimpleDevice, factory

MS = 1_000_000
RIG = load_rig("ornl_testbed")
JOG: dict[str, Any] = {"maneuver": {"name": "jog"}}


@contextmanager
def simple_rig(directory: Path) -> Iterator[tuple[LockstepRig, SimpleDevice]]:
    made: list[SimpleDevice] = []
    with LockstepRig(RIG, directory, create=factory(made)) as rig:
        yield rig, made[0]


def names_of(rig: LockstepRig) -> list[str]:
    return [event.name for event in rig.events]


def texts_of(rig: LockstepRig, name: str) -> list[str]:
    return [event.text for event in rig.events if event.name == name]


def delay_once(rig: LockstepRig, delay_ns: int) -> None:
    """The cycle under way takes so much longer."""
    rig.clock.wait_until(rig.clock.now_ns() + delay_ns)
