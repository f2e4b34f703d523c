"""The steps of a commissioning in their order, and the walk through them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from config.errors import LongreachError
from daemon.cli.commission import at_rest, identified, moving, tuned
from daemon.cli.commission.context import Context
from daemon.cli.commission.late import tells_of_lateness, whose
from daemon.cli.commission.record import Commissioning, Outcome, StepRecord, hash_of, record_of


class CommissionStep(NamedTuple):
    """`page`: where the guide says what to do when it fails. `lasts`: whether what passed before still holds on the rig; where it does
    not, the step is made again, and what rests on it keeps."""

    name: str
    do: Callable[[Context], Outcome]
    page: str
    lasts: Callable[[Context], bool] = lambda context: True


STEPS = (
    CommissionStep("rig file", at_rest.rig_file, "docs/guide/rig/rig-file.md"),
    CommissionStep("stop", at_rest.stops, "docs/guide/operate/stop.md"),
    CommissionStep("sensors", at_rest.sensors, "docs/guide/rig/wiring.md"),
    CommissionStep(
        "safe state", at_rest.safe_state, "docs/guide/operate/arming.md#prove-the-safe-state", lambda context: context.bench.proven
    ),
    CommissionStep("polarity and null", moving.polarity, "docs/guide/rig/wiring.md#4-the-first-valve"),
    CommissionStep("stop in motion", moving.stop_in_motion, "docs/guide/operate/stop.md"),
    CommissionStep(identified.IDENTIFICATION, identified.identification, "docs/guide/model/identify.md"),
    CommissionStep("design", tuned.servo_design, "docs/guide/model/identify.md"),
    CommissionStep(tuned.SHAPED_MOVE, tuned.first_shaped_move, "docs/guide/operate/maneuvers.md"),
    CommissionStep("gap", tuned.gap, "docs/guide/model/find-the-gap.md"),
)
NAMES = tuple(step.name for step in STEPS)


def walk(context: Context, commissioning: Commissioning, until: str, again: str | None) -> StepRecord | None:
    """Make every step that is not recorded as passed for this rig file yet, up to `until`; `again`: from this one on in any case.

    Ends with the first step that does not pass and returns its record; None when all passed.
    """
    sha, on = hash_of(context.loaded.text), "simulated" if context.bench.simulated else "rig"
    anew = False
    for number, step in enumerate(STEPS[: NAMES.index(until) + 1], 1):
        anew = anew or step.name == again
        kept = commissioning.records.get(step.name)
        counts = kept is not None and kept.counts_for(sha, on) and not anew
        if kept is not None and counts and step.lasts(context):
            context.say(f"{number}. {step.name}: {kept.outcome.word}, {kept.date_utc}")
            continue
        anew = not counts  # what follows rests on it
        context.say(f"{number}. {step.name}")
        record = record_of(step.name, _made(step, context), context.by, on, sha)
        commissioning.keep(record)
        context.say(f"   {record.outcome.word}: {record.outcome.text}")
        for value in record.outcome.values:
            if not value.ok:
                context.say(f"     {value.what}: {value.value} (must be: {value.limit})")
        if record.outcome.passed is False:
            return record
    return None


def _made(step: CommissionStep, context: Context) -> Outcome:
    """A step that is refused has not passed; the arm is left disarmed, or in a latched fault. It says whose fault it was that something
    was late."""
    cycles, late = context.bench.cycles()
    try:
        outcome = step.do(context)
    except LongreachError as error:
        outcome = Outcome(False, str(error))
    told = " ".join([outcome.text, context.bench.fault, *(value.value for value in outcome.values if not value.ok)])
    if outcome.passed is not False or not tells_of_lateness(told):
        return outcome
    now, late_now = context.bench.cycles()
    return replace(outcome, text=f"{outcome.text} {whose(late_now - late, now - cycles, context.loaded.path)}")
