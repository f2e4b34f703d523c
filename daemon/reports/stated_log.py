"""What a log says, in the units in which the rig file inside it states its values. A log without a rig file is left in SI."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from config.loading.stated_units import conversions, sentence_units, stated_units
from config.stated_sentences import StatedSentences
from daemon.server.stated_values import Units
from recording.files.reader import Log


def sentences_of(log: Log) -> StatedSentences:
    """For the texts of its events."""
    text = _rig_text(log)
    return StatedSentences(sentence_units(text) if text else {})


def units_of_checks(log: Log, checks: Sequence[dict[str, Any]]) -> Units:
    """For the values and limits of checks, by name."""
    text = _rig_text(log)
    return conversions({check["name"]: check["unit"] for check in checks}, stated_units(text)) if text else {}


def _rig_text(log: Log) -> str:
    return log.attachments.get("rig.yaml", b"").decode(errors="replace")
