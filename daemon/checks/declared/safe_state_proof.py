"""That outputs go safe by themselves has been proven, and that no pressure is there while they prove it."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

from config.options.canopen_rig import proofs
from config.schema.rig import Rig
from daemon.checks.checks import Reaction
from daemon.checks.declaration import (
    AGE_LIMIT_FROM,
    Declaration,
    DeclaredFact,
    Family,
    Limits,
    Purpose,
    Stage,
    Subject,
    age_limits,
    source_of,
)


def _demanded(rig: Rig, subject: Subject) -> Limits | None:
    return (0, inf) if proofs(rig)[subject["device"]] else None


def pressure_is_measured(rig: Rig) -> list[str]:
    """The joints whose supply pressure the rig measures."""
    return [joint for joint in rig.joints if f"{joint}.supply_pressure" in rig.signals]


def _supplies(rig: Rig) -> Iterator[Subject]:
    for joint in pressure_is_measured(rig):
        yield {"joint": joint, "source": source_of(rig, f"{joint}.supply_pressure")}


PROVEN = Declaration(
    name="{device} safe state proven",
    fact="{device}.proven_s",
    meaning="when the device last proved that it goes safe by itself, in the loop's time; no number: not since the daemon started",
    unit="s since the start",
    limits=_demanded,
    limit_from="any time; asked of CANopen devices with outputs unless `devices.NAME.demand_proof` is false, of others where it is true",
    source="{device}",
    reaction=Reaction.REFUSE,
    advice="Take the pressure off and run `longreach prove`; once after every start of the daemon or of the device.",
)
PRESSURE_OFF = Declaration(
    name="{joint}.supply_pressure off",
    fact="{joint}.supply_pressure_Pa",
    meaning="the supply pressure: valves open during the proof",
    unit="Pa",
    limits=lambda rig, subject: (-inf, rig.interlocks.proof_pressure_max_Pa),
    limit_from="at most `interlocks.proof_pressure_max`",
    source="{source}",
    reaction=Reaction.FAULT,
    advice="Switch the pump off, close the shut-off valve and let the accumulator down; then `longreach prove`.",
    age="{joint}.supply_pressure_age_s",
    purposes=(Purpose.PROOF,),
)
PRESSURE_AGE = Declaration(
    name="{joint}.supply_pressure age",
    fact="{joint}.supply_pressure_age_s",
    meaning="time since the sample of the supply pressure was taken",
    unit="s",
    limits=lambda rig, subject: age_limits(rig.signals[f"{subject['joint']}.supply_pressure"]),
    limit_from=AGE_LIMIT_FROM,
    source="{source}",
    reaction=Reaction.FAULT,
    advice="Check {source}; `longreach status` shows what its link counts.",
    age="{joint}.supply_pressure_age_s",
    purposes=(Purpose.PROOF,),
)

FAMILIES = (
    Family(
        "The proof of the safe state, before arming",
        Stage.PROOF,
        lambda rig: [{"device": device} for device in proofs(rig)],
        (PROVEN,),
        facts=(DeclaredFact("{device}.proven_s"),),  # written by daemon.checks.safe_state
    ),
    Family("During the proof of the safe state", Stage.PROOF, _supplies, (PRESSURE_OFF, PRESSURE_AGE)),
)
