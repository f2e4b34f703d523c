"""The option --si, and in which units a command shows values: those of the rig file, where the daemon can be asked for them."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from config.errors import DaemonError, ManeuverError
from config.stated_sentences import StatedSentences
from daemon.server.stated_values import Units, units_from


def add_si_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--si", action="store_true", help="values in SI, not in the units of the rig file")


def units_of_rig(arguments: argparse.Namespace, call: Callable[..., dict[str, Any]]) -> Units:
    """By check or joint; empty for --si and --json, and of a daemon of before this could be asked."""
    if arguments.si or arguments.json:
        return {}
    try:
        return units_from(call("units"))
    except DaemonError:
        return {}


def sentences_for(rig_text: str, si: bool) -> StatedSentences:
    """For what is told of this rig file without a daemon."""
    from config.loading.stated_units import sentence_units

    return StatedSentences({} if si else sentence_units(rig_text))


@contextmanager
def stated_refusals(rig_text: str, si: bool) -> Iterator[None]:
    """What planning refuses here, without a daemon, in the units of the rig file."""
    try:
        yield
    except (ManeuverError, DaemonError) as error:
        raise sentences_for(rig_text, si).refusal(error) from error
