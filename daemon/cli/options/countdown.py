"""The announcement before a motion, as every command that moves takes it."""

from __future__ import annotations

import argparse

from daemon.cli.options.numbers import finite
from daemon.server.protocol import LONGEST_COUNTDOWN_S


def add_countdown_option(parser: argparse.ArgumentParser) -> None:
    announced = finite(0, LONGEST_COUNTDOWN_S, "s")
    parser.add_argument("--countdown", type=announced, metavar="S", help="seconds of announcement (default: the rig's)")
