"""Quality, age and range of every required signal."""

from __future__ import annotations

from collections.abc import Iterator

from config.schema.rig import Rig
from daemon.checks.checks import Reaction
from daemon.checks.declaration import AGE_LIMIT_FROM, Declaration, Family, Stage, Subject, age_limits, open_limits, signal_subject
from drivers.contract import Quality

_LINK = "`longreach status` shows what its link counts. Then `longreach reset`."


def _required(rig: Rig) -> Iterator[Subject]:
    for name, signal in rig.signals.items():
        if signal.required:
            yield signal_subject(rig, name)


QUALITY = Declaration(
    name="{signal} quality",
    fact="{signal}.quality",
    meaning="0 good, 1 uncertain, 2 bad, as the driver judges the sample",
    unit="",
    limits=lambda rig, subject: (0, float(Quality.UNCERTAIN)),
    limit_from="not bad",
    source="{source}",
    reaction=Reaction.FAULT,
    advice=f"Check the cable and supply of {{source}}; {_LINK}",
    age="{signal}_age_s",
)
AGE = Declaration(
    name="{signal} age",
    fact="{signal}_age_s",
    meaning="time since the sample was taken",
    unit="s",
    limits=lambda rig, subject: age_limits(rig.signals[subject["signal"]]),
    limit_from=AGE_LIMIT_FROM,
    source="{source}",
    reaction=Reaction.FAULT,
    advice=f"{{source}} has gone silent, or stamps by another clock. Check its cable and supply; {_LINK}",
    age="{signal}_age_s",
)
RANGE = Declaration(
    name="{signal} range",
    fact="{field}",
    meaning="the engineering value",
    unit="{unit}",
    limits=lambda rig, subject: open_limits(rig.signals[subject["signal"]].low, rig.signals[subject["signal"]].high),
    limit_from="`signals.NAME.low` to `signals.NAME.high`",
    source="{source}",
    reaction=Reaction.FAULT,
    advice="The value cannot be true: check {source} and its calibration. Then `longreach reset`.",
    age="{signal}_age_s",
)

FAMILIES = (Family("Every required signal", Stage.SENSOR, _required, (QUALITY, AGE, RANGE)),)
