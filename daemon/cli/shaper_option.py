"""The command filter as the user names it, and as the daemon and the log know it."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from config.errors import ConfigError
from config.units import to_si

SHAPERS = (
    "none",
    "three_term",
    "zv",
    "zvd",
    "ei",
    "two_hump_ei",
    "notch",
    "robust_notch",
    "adaptive",
    "adaptive_zv",
    "adaptive_coefficients",
    "adaptive_delay",
    "zero_delay",
)
_FOCAL_NAMES = ("initial", "final", "mid")


def shaper_request(arguments: argparse.Namespace, joints: Sequence[str]) -> dict[str, Any]:
    """The `shaper` part of a run request; `joints` are the rig's. Without --both-joints the controller chooses (the rotary one)."""
    request: dict[str, Any] = {"kind": arguments.shaper}
    if arguments.both_joints:
        request["joints"] = list(joints)
    if arguments.delay is not None:
        request["delay_s"] = to_si(arguments.delay, "s")
    if arguments.focal in _FOCAL_NAMES:
        request["focal"] = arguments.focal
        return request
    try:
        request["frequency_Hz"] = to_si(arguments.focal, "Hz")
    except ConfigError as error:
        raise ConfigError("unknown focal frequency", value=arguments.focal, limit="initial, final, mid or Hz", where="--focal") from error
    return request
