"""`commission` on a rig behind CAN and Modbus, with the proof of the safe state: the twin is the rig, and its operator has the pump."""

from __future__ import annotations

from pathlib import Path

import pytest

from config.loading.load import LoadedRig
from daemon.cli.commission.bench import DaemonBench
from daemon.cli.commission.context import Context
from daemon.cli.commission.record import Commissioning
from daemon.cli.commission.steps import walk
from daemon.cli.commission.tuned import SHAPED_MOVE
from daemon.faults.benches.daemon_process import DaemonProcess, wait_for
from daemon.faults.benches.twin_process import TwinProcess, multicast_rig, patient
from daemon.server.protocol import Client
from sim_backend.twin.network_namespace import NetworkNamespace

pytestmark = [pytest.mark.slow, pytest.mark.long, pytest.mark.clock, pytest.mark.timeout(600)]

OFF_PA, ON_PA = 0.5e6, 10.4e6
TRIES = 3  # the walk goes on where it ended: a machine that stands still makes a proof fail


class Operator:
    """Says yes to everything, and has a hand on the pump's switch."""

    def __init__(self, twin: TwinProcess, client: Client) -> None:
        self._twin, self._client = twin, client
        self.asked: list[str] = []

    def __call__(self, question: str) -> bool:
        self.asked.append(question)
        if "pressure must be off" in question:
            self._twin.control.inject("plant", "supply_pressure", 0.0)
            wait_for(lambda: self._pressure_Pa() < OFF_PA, 20.0)
        elif "pressure on" in question:
            self._twin.control.clear("plant")
            wait_for(lambda: self._pressure_Pa() > ON_PA, 20.0)
        return True

    def _pressure_Pa(self) -> float:
        checks = {check["name"]: check["value"] for check in self._client.call("checks")["checks"]}
        return float(checks["rotary.supply_pressure range"] or 0.0)


# With the limits of the shipped rig file it wants two quiet processors.
@pytest.mark.parametrize("limits", ["patient", pytest.param("shipped", marks=pytest.mark.hil)])
def test_from_the_rig_file_to_the_first_shaped_move(namespace: NetworkNamespace, tmp_path: Path, limits: str) -> None:
    text = patient(multicast_rig()) if limits == "patient" else multicast_rig()
    with TwinProcess(namespace, tmp_path, text) as twin:
        daemon = DaemonProcess(tmp_path, text=text, prefix=namespace.prefix)
        try:
            with daemon.connect() as client:
                said: list[str] = []
                loaded, operator = LoadedRig(twin.rig, text, str(twin.rig_file)), Operator(twin, client)
                commissioning = Commissioning.read(tmp_path / "out", twin.rig.name)
                context = Context(loaded, DaemonBench(twin.rig, client), commissioning.folder, operator, said.append, effort=1,
                                  identify="payload", records=commissioning.records)  # fmt: skip
                failed = walk(context, commissioning, SHAPED_MOVE, None)
                for _ in range(TRIES - 1):
                    failed = failed and walk(context, commissioning, SHAPED_MOVE, None)
                assert failed is None, said
                proof = commissioning.records["safe state"].outcome
                assert proof.passed is True
                assert len(proof.values) == 4, "two valves, each without our heartbeat and without set points"
                identified = commissioning.records["identification"].outcome
                payload = next(value for value in identified.values if value.what.startswith("payload"))
                assert float(payload.value.split()[0]) == pytest.approx(45 * 0.45359237, rel=0.1)
                moved = commissioning.records[SHAPED_MOVE].outcome
                left = {value.what: float(value.value.split()[0]) for value in moved.values[2:]}
                assert left["vibration left, adaptive"] < 0.5 * left["vibration left, unshaped"]
                assert Path(moved.files[0]).exists(), "the report"
                assert client.call("status")["mode"] == "disarmed"
        finally:
            daemon.end()
