"""The paper's program through daemon, CANopen and Modbus at 1 kHz: `make hil`. Its hold vibration is that of the in-process run within
10 %, and the log says how long the cycles took and how old the frames were.

Daemon and twin have a processor each. The machine may be shared: late cycles and frames are forgiven here, and counted.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.loading.load import load_rig
from daemon.cli.demo.demo_report import timing_summary
from daemon.faults.benches.commissioning import commission
from daemon.faults.benches.twin_process import TwinProcess, multicast_rig, patient
from daemon.lockstep import run_lockstep
from recording.evaluation.replay import reexecute
from recording.evaluation.vibration import hold_vibration
from recording.files.reader import Log, read_log
from sim_backend.twin.network_namespace import NetworkNamespace
from tests.support.daemon.running_daemon import RunningDaemon, until

pytestmark = pytest.mark.clock

LINE = {"maneuver": {"name": "paper_line"}, "approach": True, "countdown_s": 0.0}


def figures(log: Log) -> dict[str, object]:
    """Cycle time and age of the positions, from the cycles themselves."""
    columns = log.columns
    whole_us = columns["read_us"] + columns["compute_us"] + columns["write_us"]
    ages_ms = 1e3 * np.maximum(columns["rotary.position_age_s"], columns["prismatic.position_age_s"])
    p50_us, p99_us = np.quantile(whole_us, (0.5, 0.99))
    share = f"{100 * np.mean(ages_ms > 2.0):.2f} %"
    return {"read_compute_write_p50_us": round(p50_us), "p99_us": round(p99_us), "cycles with a position older than 2 ms": share}


def assert_old_frames_were_counted(log: Log, joint: str) -> None:
    """What the driver has counted between two notes in the log is what the ages of every cycle say."""
    key = f"{joint}_encoder.stale"
    notes = [event for event in log.events if event.name == "link" and key in event.values]
    first, last = notes[0], notes[-1]
    between = (log.columns["cycle"] > first.cycle) & (log.columns["cycle"] <= last.cycle)
    old = int(np.sum(log.columns[f"{joint}.position_age_s"][between] > 2e-3))
    assert last.cycle - first.cycle > 10_000
    assert last.values[key] - first.values[key] == old


@pytest.mark.hil
def test_the_papers_program_over_can_and_modbus(twin: TwinProcess, namespace: NetworkNamespace, tmp_path: Path) -> None:
    rig_file = tmp_path / "can.yaml"
    rig_file.write_text(patient(multicast_rig()))
    with namespace.entered(), RunningDaemon(tmp_path, str(rig_file)) as daemon:
        with daemon.wait_until_ready() as client:
            commission(client, twin.control)
            run = client.call("start", **LINE)["run"]
            until(lambda: client.call("wait", run=run, timeout_s=1.0)["validity"] != "running", 90.0)
            assert client.call("wait", run=run, timeout_s=1.0)["validity"] == "valid", client.call("wait", run=run, timeout_s=1.0)
            client.call("disarm")
        log = read_log(daemon.latest_log())
    assert reexecute(log.path).identical
    for joint in ("rotary", "prismatic"):
        assert_old_frames_were_counted(log, joint)
    assert b"udp_multicast" in log.attachments["rig.yaml"], "the log says which bus it took"
    in_process = read_log(run_lockstep(load_rig("ornl_testbed"), [LINE], tmp_path / "in-process")[0])
    over_the_bus, reference = hold_vibration(log), hold_vibration(in_process)
    print({"bus": [h.amplitude_mps2 for h in over_the_bus], "in process": [h.amplitude_mps2 for h in reference]})
    print(timing_summary(log) | figures(log))
    for seen, expected in zip(over_the_bus, reference, strict=True):
        assert seen.amplitude_mps2 == pytest.approx(expected.amplitude_mps2, rel=0.1)
