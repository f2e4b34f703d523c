"""A lockstep rig of two valves that prove their safe state, of sensors, and of a pressure that can be switched off."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text
from config.schema.rig import Device, Rig
from daemon.lockstep import LockstepRig
from drivers.contract import Driver
from drivers.proof import ProofResult, ProofSteps, not_proven, proof
from tests.support.daemon.simple_device import SimpleDevice

VALVES = ("rotary_valve", "prismatic_valve")
PRESSURES = ("rotary.supply_pressure", "prismatic.supply_pressure")
OPEN_CYCLES = 20


def _fast() -> LoadedRig:
    """No I/O process in lockstep: the gauges are read in the loop."""
    text = apply_overrides(load_rig("ornl_testbed_can").text, ["devices.hydraulic_unit.slow=false"])
    return LoadedRig(rig_from_text(text), text, "proving.yaml")


RIG = _fast()


class ProvingValve(SimpleDevice):
    """Stays open for OPEN_CYCLES in each of two proofs. `late_s`: seconds it takes to become safe; None: it never does."""

    def __init__(self, name: str, device: Device, rig: Rig, lockstep: bool) -> None:
        super().__init__(name, device, rig, lockstep)
        self.is_open = False
        self.late_s: float | None = 0.06
        self.on_prove: Callable[[], None] = lambda: None

    def prove_safe_state(self) -> ProofSteps:
        for what in ("a missed heartbeat", "missing set points"):
            self.is_open = True
            for _ in range(OPEN_CYCLES):
                self.on_prove()
                yield
            self.is_open = False
            yield proof(f"{self.name}: {what}", self.late_s, 0.09, "as told")

    def safe(self) -> None:
        super().safe()
        self.is_open = False


def refuses_to_open(valve: ProvingValve) -> None:
    """Its proof cannot even begin."""

    def steps() -> Iterator[ProofResult]:
        yield not_proven(valve.name, 0.09, "the spool did not open")

    valve.prove_safe_state = steps  # type: ignore[assignment,method-assign]


@contextmanager
def proving_rig(directory: Path) -> Iterator[tuple[LockstepRig, dict[str, SimpleDevice]]]:
    made: dict[str, SimpleDevice] = {}

    def create(name: str, device: Device, rig: Rig, lockstep: bool) -> Driver:
        made[name] = (ProvingValve if name in VALVES else SimpleDevice)(name, device, rig, lockstep)
        return made[name]

    with LockstepRig(RIG, directory, create=create) as rig:
        yield rig, made


def pressure(devices: dict[str, SimpleDevice], on: bool) -> None:
    gauges = devices["hydraulic_unit"].override
    for name in PRESSURES:
        gauges.pop(name, None)
        if not on:
            gauges[name] = 0.0
