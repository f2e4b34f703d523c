"""Makes the runs of an identification: each on a fresh simulated rig in lockstep, or one after the other on the daemon's rig."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from config.errors import DaemonError, LongreachError
from config.loading.load import LoadedRig, apply_overrides, rig_from_text
from config.progress import Progress
from daemon.cli.operate.motion_commands import wait_for
from daemon.lockstep import run_lockstep
from daemon.server.protocol import Client
from tuning.experiments.experiments import CampaignRun


def in_lockstep(loaded: LoadedRig, experiments: Sequence[CampaignRun], out: Path, seed: int, progress: Progress) -> list[Path]:
    """One log an experiment. A run that was stopped by an interlock is told and left out; DaemonError when none is left."""
    logs, why = list[Path](), ""
    for number, experiment in enumerate(experiments, 1):
        progress(f"{number}/{len(experiments)} {experiment.name}")
        text = apply_overrides(loaded.text, experiment.overrides)
        request = {"maneuver": {"text": experiment.maneuver, "name": experiment.name}, "approach": True}
        try:
            logs += run_lockstep(LoadedRig(rig_from_text(text, loaded.path), text, loaded.path), [request], out, seed + number)
        except LongreachError as error:
            why = str(error)
            progress(f"  left out: {why}")
    return _some(logs, len(experiments), why)


def on_daemon(client: Client, experiments: Sequence[CampaignRun], progress: Progress) -> list[Path]:
    """The runs of an armed rig; they share the recording of its arming. The operator arms, watches and can stop."""
    logs, why = list[Path](), ""
    for number, experiment in enumerate(experiments, 1):
        progress(f"{number}/{len(experiments)} {experiment.name}")
        run = client.call("start", maneuver={"text": experiment.maneuver, "name": experiment.name}, approach=True)
        result = wait_for(client, run["run"])
        if result["validity"] != "valid":
            why = result.get("reason", "")
            progress(f"  left out: {why}")
            if client.call("status")["mode"] != "holding":
                raise DaemonError("the rig does not hold any more", value=result.get("reason", ""), next_step="See `longreach why`.")
        else:  # a long recording is cut between two runs: the run is in one of the two
            logs += [path for path in dict.fromkeys((Path(run["log"]), Path(result["log"]))) if path not in logs]
    return _some(logs, len(experiments), why)


def _some(logs: list[Path], asked: int, why: str) -> list[Path]:
    if not logs:
        raise DaemonError("no run was valid", value=f"0 of {asked}", next_step=f"The last one: {why}")
    return logs
