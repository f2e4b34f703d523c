"""What is commissioned: the rig behind its daemon, or the rig file's plant in lockstep, through the same few verbs."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from config.errors import DaemonError, LogError, LongreachError
from config.loading.load import LoadedRig
from config.loading.stand_in import with_simulated_devices
from config.schema.rig import Rig
from daemon.cli.operate.motion_commands import wait_for
from daemon.lockstep import LockstepRig
from daemon.modes.mode_machine import OperatorAction
from daemon.modes.run_watch import RunVerdict
from daemon.server.protocol import Client
from recording.files.reader import read_log
from recording.format.fields import field_of_signal
from servo_control.signals import Mode

SAMPLES = 100
POLL_S = 0.02
RESTED_S = 10.0  # longest wait for another mode
AT_REST = ("holding", "fault", "disarmed")
_ACTIONS = {"reset": OperatorAction.RESET, "arm": OperatorAction.ARM, "disarm": OperatorAction.DISARM, "estop": OperatorAction.ESTOP}

Readings = dict[str, npt.NDArray[np.float64]]


@dataclass(frozen=True, slots=True)
class Ran:
    """One armed run. `mode`: in which the arm was at its end, before it was disarmed; `reason`: why it is not valid."""

    log: Path
    run: int
    valid: bool
    reason: str
    mode: str


class Bench(Protocol):
    rig: Rig
    simulated: bool

    @property
    def latched(self) -> bool:
        """A fault or the e-stop is latched, until a reset."""

    @property
    def fault(self) -> str:
        """What is latched as a fault, in words; empty where nothing is, and in the simulation."""

    @property
    def proven(self) -> bool:
        """No device waits for its proof of the safe state, which is due after every start of the daemon."""

    def act(self, verb: str) -> str:
        """reset, arm, disarm or estop; the mode after it. DaemonError when it is refused."""

    def cycles(self) -> tuple[int, int]:
        """Cycles of the loop so far, and those that ended late."""

    def readings(self) -> Readings:
        """Every signal of the rig file, some SAMPLES times, in SI."""

    @property
    def proves(self) -> bool:
        """Some device of the rig is asked for the proof of its safe state."""

    def prove(self) -> dict[str, Any]:
        """The proof of the safe state, as the socket's `prove` answers."""

    def run(self, request: Mapping[str, Any], stop_after_s: float | None = None) -> Ran:
        """Arm, run (stop after that long), disarm, also where the run is refused."""


class LockstepBench:
    """The simulated rig, without a daemon and without the wall clock. Use it in a with statement."""

    simulated = True
    proven, proves, fault = True, False, ""

    def __init__(self, loaded: LoadedRig, logs: Path) -> None:
        simulated = with_simulated_devices(loaded)
        self.rig = simulated.rig
        self._rig = LockstepRig(simulated, logs)
        self._rig.cycles(2)

    @property
    def latched(self) -> bool:
        return self._rig.mode is Mode.FAULT

    def act(self, verb: str) -> str:
        if verb == "arm":
            if self._rig.mode is not Mode.DISARMED:
                raise DaemonError("arming refused", value=self._mode, limit="disarmed", next_step="`longreach reset` first.")
            self._rig.arm()
            return self._mode
        self._rig.post(_ACTIONS[verb])
        self._rig.cycles(3)
        return self._mode

    def cycles(self) -> tuple[int, int]:
        return 0, 0  # nothing is late without a clock

    def readings(self) -> Readings:
        names = list(self.rig.signals)
        rows = []
        for _ in range(SAMPLES):
            self._rig.cycles(2)
            rows.append([self._rig.value(field_of_signal(name)) for name in names])
        return dict(zip(names, np.array(rows, dtype=np.float64).T, strict=True))

    def prove(self) -> dict[str, Any]:
        raise DaemonError("the simulated rig has no safe state to prove")

    def run(self, request: Mapping[str, Any], stop_after_s: float | None = None) -> Ran:
        self._rig.arm()
        try:
            number = self._rig.start(request)
        except LongreachError:
            self._rig.disarm()
            raise
        run, every = self._rig.loop.keeper.run, round(0.05 * self.rig.loop.rate_Hz)
        stopping = None if stop_after_s is None else round(stop_after_s * self.rig.loop.rate_Hz / every)
        ticks = 0
        while run.active:
            self._rig.cycles(every)
            ticks += 1
            if ticks == stopping:
                self._rig.post(OperatorAction.STOP)
        mode = self._mode
        self._rig.disarm()
        if mode == "fault":
            self._rig.cycles(3 * round(self.rig.loop.rate_Hz))  # a fault records on
        return Ran(self._rig.recorder.finished[-1], number, run.verdict is RunVerdict.VALID, run.reason, mode)

    @property
    def _mode(self) -> str:
        return self._rig.mode.name.lower()

    def __enter__(self) -> LockstepBench:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._rig.loop.end()


class DaemonBench:
    """The rig of a daemon, or the twin behind it."""

    simulated = False

    def __init__(self, rig: Rig, client: Client) -> None:
        self.rig, self._client = rig, client
        served = client.call("status")["rig"]
        if served != rig.name:
            advice = "Start longreachd with the rig file that is to be commissioned."
            raise DaemonError("the daemon runs another rig", value=served, limit=rig.name, next_step=advice)

    @property
    def latched(self) -> bool:
        status = self._client.call("status")
        return bool(status["mode"] == "fault" or status["estop"] != "released")

    @property
    def fault(self) -> str:
        fault = self._client.call("status")["fault"]
        return "" if fault is None else str(fault["text"])

    @property
    def proven(self) -> bool:
        devices = self._client.call("status")["safe_state"].values()
        return all(device["proven_s"] is not None for device in devices if device["demanded"])

    def act(self, verb: str) -> str:
        self._client.call(verb)
        return self._mode

    def cycles(self) -> tuple[int, int]:
        status = self._client.call("status")
        return int(status["cycle"]), int(status["loop"]["overruns"])

    def readings(self) -> Readings:
        """What the daemon believes it reads, a signal without limits too."""
        names, rows = list(self.rig.signals), []
        order = [name for name, _ in self._client.call("rig")["signals"]]
        columns = [order.index(field_of_signal(name)) for name in names]
        for _ in range(SAMPLES):
            (row,) = self._client.call("sample")["rows"]
            rows.append([_number(row[column]) for column in columns])
            time.sleep(POLL_S)
        return dict(zip(names, np.array(rows, dtype=np.float64).T, strict=True))

    @property
    def proves(self) -> bool:
        return bool(self._client.call("status")["safe_state"])

    def prove(self) -> dict[str, Any]:
        """The operator has said that the pressure is off; where it is measured, the daemon looks as well."""
        return self._client.call("prove", pressure_is_off=True)

    def run(self, request: Mapping[str, Any], stop_after_s: float | None = None) -> Ran:
        self._client.call("arm")
        try:
            ran = self._armed_run(request, stop_after_s)
        except (KeyboardInterrupt, OSError):  # Ctrl-C, a terminal that is gone: nobody looks after the arm any more
            self._client.call("stop")
            self._until(AT_REST)
            raise
        finally:
            self._client.call("disarm")
        return _closed(ran)

    def _armed_run(self, request: Mapping[str, Any], stop_after_s: float | None) -> Ran:
        run = self._client.call("start", **request, settle_s=RESTED_S)
        if stop_after_s is not None:
            time.sleep(float(run["countdown_s"]) + stop_after_s)
            self._client.call("stop")
        result = wait_for(self._client, run["run"])
        self._until(AT_REST)
        log = Path(self._client.call("status")["log"]["path"])
        return Ran(log, int(run["run"]), result["validity"] == "valid", result.get("reason", ""), self._mode)

    @property
    def _mode(self) -> str:
        return str(self._client.call("status")["mode"])

    def _until(self, modes: tuple[str, ...]) -> None:
        limit = time.monotonic() + RESTED_S
        while self._mode not in modes and time.monotonic() < limit:
            time.sleep(POLL_S)


def _closed(ran: Ran) -> Ran:
    """The recorder writes behind the loop: a log read before it is closed may lack the end of its run."""
    limit = time.monotonic() + RESTED_S
    while not _is_closed(ran.log):
        if time.monotonic() > limit:
            advice = "`longreach why` tells whether the recorder keeps up. Then `longreach commission` again."
            raise DaemonError("the log of the run is not closed", value=f"{RESTED_S:g} s", where=str(ran.log), next_step=advice)
        time.sleep(5 * POLL_S)
    return ran


def _is_closed(log: Path) -> bool:
    try:
        return read_log(log).complete
    except LogError:  # not a cycle of it is on the disk yet
        return False


def _number(value: Any) -> float:
    return float("nan") if value is None else float(value)
