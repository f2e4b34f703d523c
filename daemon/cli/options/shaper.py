"""The command filter as the user names it, and as the daemon and the log know it."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from config.errors import ConfigError
from servo_control.shapers.shaper_choice import FOCAL, KINDS


def add_shaper_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--shaper", default="none", choices=KINDS, help="command filter (default none)")
    parser.add_argument(
        "--focal", default="mid", help="focal frequency of a fixed filter: initial, final, mid or a number in Hz (default mid)"
    )
    parser.add_argument("--delay", metavar="T", help="spacing of three_term's impulses, e.g. '70 ms' (default: half a period = zvd)")
    parser.add_argument("--both-joints", action="store_true", help="filter both joints, so that the line stays straight")


def shaper_request(arguments: argparse.Namespace, joints: Sequence[str]) -> dict[str, Any]:
    """The `shaper` part of a run request; `joints` are the rig's. Without --both-joints the controller chooses (the rotary one)."""
    from config.units import to_si

    request: dict[str, Any] = {"kind": arguments.shaper}
    if arguments.both_joints:
        request["joints"] = list(joints)
    if arguments.delay is not None:
        request["delay_s"] = to_si(arguments.delay, "s")
    if arguments.focal in FOCAL:
        request["focal"] = arguments.focal
        return request
    try:
        request["frequency_Hz"] = to_si(arguments.focal, "Hz")
    except ConfigError as error:
        what, limit = "unknown focal frequency", "initial, final, mid or Hz"
        raise ConfigError(what, value=arguments.focal, limit=limit, where="--focal", mend={"--focal": "mid"}) from error
    return request
