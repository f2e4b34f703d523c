"""`commission RIG`: from a rig file to its first shaped move, step by step, with a record of each."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import EXIT_REFUSED, UsageError
from daemon.cli.connection import add_json_option, connect
from daemon.cli.options.numbers import COUNT

if TYPE_CHECKING:
    from config.loading.load import LoadedRig
    from daemon.cli.commission.bench import Bench

_DESCRIPTION = """\
Walks through the commissioning of a rig: rig file, stop, sensors, proof of the safe state, polarity and null of the valves by tiny moves,
a stop in motion, identification, design, the first shaped move, the gap. It asks before each motion. What passed is kept in --out and not
made again while the rig file stays the same. Exit 1 when a step does not pass.
"""
_AT_REST = "; a run was brought to rest and the arm disarmed: the same command goes on with this step"


def options(parser: argparse.ArgumentParser) -> None:
    parser.description = _DESCRIPTION
    parser.add_argument("rig", metavar="RIG.yaml", help="the rig file that the daemon runs, or the name of a shipped one")
    parser.add_argument("--simulated", action="store_true", help="on the rig file's plant in lockstep, without a daemon")
    parser.add_argument("--out", type=Path, metavar="DIR", help="records, logs and the report (default ./commissioning-RIG)")
    parser.add_argument("--yes", action="store_true", help="ask nothing: every motion is allowed, every reading agrees")
    parser.add_argument("--until", metavar="STEP", default="gap", help="the last step to make (default gap); a word of --list")
    parser.add_argument("--again", metavar="STEP", help="from this step on, make them again although they passed")
    parser.add_argument("--list", action="store_true", help="the steps and what is recorded of them; makes none")
    parser.add_argument(
        "--maneuver",
        default="",
        metavar="NAME",
        help="of the first shaped move (default paper_line, or plain moves where a rig cannot run it)",
    )
    parser.add_argument("--shaper", default="adaptive", help="command filter of the first shaped move (default adaptive)")
    parser.add_argument("--identify", choices=("payload", "map"), default="map", help="one move, or small moves over the travel (default)")
    parser.add_argument("--effort", type=COUNT, default=25, help="generations of the compensator's search (default 25)")
    add_json_option(parser)
    parser.set_defaults(run_command=_commission, when_interrupted=_AT_REST)


def _commission(arguments: argparse.Namespace) -> int:
    from config.loading.load import load_rig
    from daemon.cli.commission.commissioning_page import write_page
    from daemon.cli.commission.context import Context
    from daemon.cli.commission.record import Commissioning
    from daemon.cli.commission.steps import walk
    from daemon.host.host_facts import user_and_host

    loaded = load_rig(arguments.rig)
    folder: Path = arguments.out or Path(f"commissioning-{loaded.rig.name}")
    commissioning = Commissioning.read(folder, loaded.rig.name)
    for name in filter(None, (arguments.until, arguments.again)):
        _known(name)
    if arguments.list:
        return _list(arguments, commissioning)
    if not (arguments.yes or sys.stdin.isatty()):
        raise _nobody_to_ask(arguments.simulated, loaded)
    folder.mkdir(parents=True, exist_ok=True)
    with _bench(arguments, loaded, folder) as bench:
        context = Context(loaded, bench, folder, _asker(arguments.yes), _tell, arguments.maneuver, arguments.shaper, arguments.effort,
                          arguments.identify, user_and_host(), commissioning.records)  # fmt: skip
        failed = walk(context, commissioning, arguments.until, arguments.again)
    _report(arguments, commissioning, failed, write_page(commissioning, loaded.text))
    return EXIT_REFUSED if failed else 0


def _nobody_to_ask(simulated: bool, loaded: LoadedRig) -> UsageError:
    """--yes would say that the pressure is off and that a joint moved as it should: it is proposed where nothing can move."""
    what, advice = "nobody can be asked before motion", "Run it on a terminal"
    if simulated or all(device.driver == "sim" for device in loaded.rig.devices.values()):
        return UsageError(what, where="commission", next_step=f"{advice}, or with --yes.", mend={"--yes": ""})
    if loaded.rig.plant is None:
        return UsageError(what, where="commission", next_step=f"{advice}.")
    advice += ", or the simulated rig with --simulated --yes."
    return UsageError(what, where="commission", next_step=advice, mend={"--simulated": "", "--yes": ""})


def _report(arguments: argparse.Namespace, commissioning: Any, failed: Any, page: Path) -> None:
    """Where the report is, and what is to be put right."""
    if arguments.json:
        print(json.dumps({**commissioning.as_dict(), "failed": failed.step if failed else None, "page": str(page)}))
        return
    print(f"report: {page}")
    if failed is not None:
        print(f"{failed.step} did not pass: {failed.outcome.text}\nput it right, then the same command goes on from there")


@contextmanager
def _bench(arguments: argparse.Namespace, loaded: LoadedRig, folder: Path) -> Iterator[Bench]:
    from daemon.cli.commission.bench import DaemonBench, LockstepBench

    if arguments.simulated:
        with LockstepBench(loaded, folder / "logs") as bench:
            yield bench
        return
    with connect(arguments) as client:
        yield DaemonBench(loaded.rig, client)


def _known(name: str) -> None:
    from config.parsing.nearest import nearest_text
    from daemon.cli.commission.steps import NAMES

    if name not in NAMES:
        raise UsageError(f"unknown step {name!r}{nearest_text(name, NAMES)}", limit=", ".join(NAMES), where="commission")


def _list(arguments: argparse.Namespace, commissioning: Any) -> int:
    from daemon.cli.commission.steps import NAMES

    if arguments.json:
        print(json.dumps(commissioning.as_dict()))
        return 0
    for name in NAMES:
        record = commissioning.records.get(name)
        word = "to do" if record is None else record.outcome.word
        print(f"{name:20} {word:18} {record.date_utc if record else ''}".rstrip())
    return 0


def _asker(yes: bool) -> Any:
    def ask(question: str) -> bool:
        if yes:
            _tell(f"   {question} yes (--yes)")
            return True
        return input(f"   {question} [y/N] ").strip().lower() in ("y", "yes")

    return ask


def _tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
