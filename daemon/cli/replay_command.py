"""`replay`: re-execute the controller from the log alone, or with one thing changed."""

from __future__ import annotations

import argparse
import dataclasses
import json
from pathlib import Path
from typing import Any

from daemon.cli.connection import add_json_option
from recording.replay import reexecute


def register(commands: Any) -> None:
    parser = commands.add_parser("replay", help="re-execute a log's controller and compare bit for bit")
    parser.add_argument("log", type=Path, metavar="LOG.mcap")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="re-execute with a change, e.g. --set servo.rotary.gain='0.5 V/deg'"
    )
    add_json_option(parser)
    parser.set_defaults(run_command=_replay)


def _replay(arguments: argparse.Namespace) -> int:
    """Exit 0 when bit-identical (or when a difference was asked for with --set), 1 when it diverges."""
    result = reexecute(arguments.log, tuple(arguments.set))
    print(json.dumps(dataclasses.asdict(result), default=str) if arguments.json else result.text())
    return 0 if result.identical or arguments.set else 1
