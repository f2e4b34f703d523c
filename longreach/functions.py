"""What `import longreach` offers, each function a few lines around the room that does the work."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import LogError, UsageError

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from config.schema.rig import Rig
    from daemon.server.stream_client import Stream
    from recording.evaluation.log_difference import LogDifference
    from recording.evaluation.replay import ReplayResult
    from recording.files.catalogue import Recorded
    from recording.files.reader import Log


def load_log(path: str | Path) -> Log:
    """A recording: `columns` by name (`rotary.command_V`, SI, one entry a cycle), events, attachments. LogError where it is none."""
    from recording.files.reader import read_log

    return read_log(path)


def frame(log: Log) -> Any:
    """The log's columns as a pandas DataFrame with the index `t_s`."""
    try:
        import pandas
    except ImportError as error:
        advice = "Install it beside longreach: pip install pandas. log.columns holds the same as numpy arrays."
        raise LogError("a frame needs the library pandas", where=str(log.path), next_step=advice) from error
    return pandas.DataFrame(log.columns).set_index("t_s")


def load_rig(rig: str | Path) -> Rig:
    """A rig file, or a shipped rig by name, checked. ConfigError lists every problem with its line."""
    from config.loading.load import load_rig as load

    return load(rig).rig


def simulate(
    rig: str | Path,
    maneuver: str,
    *,
    out: str | Path,
    shaper: str = "none",
    settings: Mapping[str, str] | None = None,
    parameters: Mapping[str, str] | None = None,
    seed: int = 0,
) -> Log:
    """Run a maneuver on the simulated rig as the daemon would, and return its log, written to `out`.

    `settings` change the rig file, `parameters` the maneuver, both as a user writes them: {"servo.rotary.gain": "0.4 V/deg"}.
    UsageError where `out` exists; LongreachError where rig, maneuver or run are refused.
    """
    from config.loading.load import changed_rig, read_text
    from config.loading.load import load_rig as load
    from config.loading.stand_in import with_simulated_devices
    from daemon.lockstep import run_into

    out = Path(out)
    if out.exists():
        raise UsageError("the log exists already", where=str(out), next_step="Choose another name; recordings are never written over.")
    loaded = load(rig)
    written = {"text": read_text(Path(maneuver)), "name": maneuver} if Path(maneuver).suffix else {"name": maneuver}
    request = {"maneuver": written, "parameters": _as_written(parameters), "shaper": {"kind": shaper}, "approach": True}
    changed = changed_rig(loaded.text, loaded.path, _as_written(settings))
    return load_log(run_into(out, with_simulated_devices(changed), request, seed))


def drive(
    *, socket: str | Path | None = None, shaper: Mapping[str, Any] | None = None, countdown_s: float | None = None
) -> AbstractContextManager[Stream]:
    """Drive an armed rig by hand, from a joystick or any program: a `Stream` for a with statement, at whose end the arm comes to rest.

    `socket` of the daemon, by default where the command line looks; `shaper` as in a run request, by default the rig's. DaemonError
    when the rig is not armed, and from the stream's methods when the run is over, with the reason.
    """
    from daemon.processes.paths import socket_path
    from daemon.server.protocol import Client
    from daemon.server.stream_client import Stream

    @contextmanager
    def driving() -> Iterator[Stream]:
        with (
            Client(socket_path(str(socket) if socket else None)) as client,
            Stream(client, dict(shaper) if shaper else None, countdown_s) as stream,
        ):
            stream.wait_until_driving()
            yield stream

    return driving()


def run_plant(
    rig: str | Path, commands_V: ArrayLike, period_s: float, *, start: Sequence[float] | None = None, seed: int = 0
) -> dict[str, NDArray[np.float64]]:
    """The simulated plant alone under given commands (rows × joints, V, each held for `period_s`): positions, velocities, spools and every
    signal's true value by name, a row per command. `start`: positions of the joints in rad and m."""
    from sim_backend.plant import SimulatedRig

    plant = SimulatedRig(load_rig(rig), seed)
    if start is not None:
        plant.reset(list(start))
    return plant.run(commands_V, period_s)


def replay(log: str | Path, changes: Mapping[str, str] | None = None) -> ReplayResult:
    """Run the log's controller again: `identical` bit for bit, or with `changes` of the rig file how much each signal differs."""
    from recording.evaluation.replay import reexecute

    return reexecute(log, _as_written(changes))


def _as_written(changes: Mapping[str, str] | None) -> list[str]:
    """KEY=VALUE, as on the command line."""
    return [f"{key}={value}" for key, value in (changes or {}).items()]


def runs(*places: str | Path) -> list[Recorded]:
    """What every log in these folders (or these logs) holds, read from the end of each file: `.runs` with maneuver, filter and validity,
    `.begun` with when each began. Logs that cannot be used are left out; LogError for a place that is no folder and no file."""
    from recording.files.catalogue import logs_in, recorded

    found = []
    for path in logs_in(map(Path, places)):
        with suppress(LogError):
            found.append(recorded(path))
    return found


def compare(a: str | Path, b: str | Path, runs: tuple[int, int] | None = None) -> LogDifference:
    """What differs between a run of `a` and one of `b` (default: the first of each): values of rig, maneuver and filter; every signal,
    aligned on the start of the run, in the units of A's rig file."""
    from recording.evaluation.log_difference import difference

    return difference(load_log(a), load_log(b), runs)


def report(log: str | Path, run: int | None = None, *, simulate: bool = True) -> list[Path]:
    """Write the page of each run of a log (or of one) beside it, with the same run on the simulated rig unless `simulate` is false."""
    from daemon.reports.run_report import write_reports

    return write_reports(Path(log), None if run is None else [run], simulate)


def design(rig: str | Path, *, effort: int = 25) -> list[str]:
    """The compensator of an arm's rotary joint, or of a single hydraulic axis, that is stiffest with margins over the whole workspace, as
    changes of the rig file."""
    from math import inf

    from tuning.loop_design.arm_design import as_overrides
    from tuning.loop_design.arm_design import design as search

    loaded = load_rig(rig)
    found = search(loaded, loaded.end_point.gain if loaded.end_point else 0.0, effort=effort, largest_cycle=inf)
    return as_overrides(loaded, found.chosen.servo)


def find_gap(
    rig: str | Path, logs: Sequence[str | Path], holdouts: Sequence[str | Path], *, out: str | Path, propose: bool = False
) -> dict[str, Any]:
    """Search for the physics the rig file lacks; findings.json as a dictionary, written to `out` with the improved rig file and the report.

    LogError for data that cannot carry a verdict, with the channel and what to do.
    """
    from gap.find import find
    from gap.settings import Settings

    fit, held = [Path(log) for log in logs], [Path(log) for log in holdouts]
    return find(rig, fit, held, Path(out), lambda line: None, Settings(propose=propose)).content
