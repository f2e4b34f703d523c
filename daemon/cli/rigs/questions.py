"""What `new-rig` asks: each number by a flag, or on a terminal by a question, in the words and units of a data sheet."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from config.errors import LongreachError, UnitError, UsageError
from config.parsing.nearest import nearest_text

CYLINDER, ROTARY, ARM = "cylinder", "rotary", "arm"


@dataclass(frozen=True, slots=True)
class Question:
    """One number or word. `unit`: what it must convert to ("" for a word); `kinds`: for which actuators; without default it is needed.
    A number is above 0 unless it may be 0."""

    flag: str
    text: str
    unit: str
    default: str | None = None
    kinds: tuple[str, ...] = (CYLINDER, ROTARY, ARM)
    may_be_zero: bool = False

    @property
    def key(self) -> str:
        return self.flag.replace("-", "_")


_EXAMPLES = {
    "m": "'16 mm'",
    "kg": "'45 kg'",
    "rad": "'90 deg'",
    "m^3": "'20 cm^3'",
    "m^3/s": "'10 l/min'",
    "Pa": "'70 bar'",
    "V": "'10 V'",
    "s": "'10 ms'",
}
_BEYOND_ANY_MACHINE = 1e12  # in SI; what is merely out of range, the schema tells with its limit
AXES = (CYLINDER, ROTARY)
QUESTIONS = (
    Question("joint", "name of the joint", "", "axis", AXES),
    Question("bore", "bore of the cylinder", "m", None, (CYLINDER, ARM)),
    Question("rod", "diameter of the rod (0 mm: none)", "m", None, (CYLINDER, ARM), may_be_zero=True),
    Question("stroke", "stroke between the stops", "m", None, (CYLINDER,)),
    Question("mass", "moving mass", "kg", None, (CYLINDER,)),
    Question("displacement", "oil per angle of the rotary actuator, e.g. '10 in^3/rad'", "m^3/rad", None, (ROTARY, ARM)),
    Question("angle", "angle between its stops", "rad", None, (ROTARY, ARM)),
    Question("inertia", "turning inertia", "kg*m^2", None, (ROTARY,)),
    Question("shortest", "hub's axis to payload, retracted", "m", None, (ARM,)),
    Question("longest", "hub's axis to payload, extended", "m", None, (ARM,)),
    Question("tube-outside", "outer diameter of the link's tube", "m", None, (ARM,)),
    Question("tube-inside", "inner diameter of the tube (0 mm: a rod)", "m", None, (ARM,), may_be_zero=True),
    Question("tube-length", "whole length of the tube, with what stays in its bearing", "m", None, (ARM,)),
    Question("tube-material", "steel or aluminium", "", "steel", (ARM,)),
    Question("hub-inertia", "inertia of what turns and does not slide", "kg*m^2", None, (ARM,), may_be_zero=True),
    Question("carriage", "mass of rod, piston and carriage, which slide with the tube", "kg", None, (ARM,), may_be_zero=True),
    Question("payload", "mass at the tip", "kg", None, (ARM,), may_be_zero=True),
    Question("dead-volume", "oil between valve and each chamber at its smallest", "m^3", "20 cm^3"),
    Question("rated-flow", "rated flow of the valve", "m^3/s", None, AXES),
    Question("rotary-flow", "rated flow of the hub's valve", "m^3/s", None, (ARM,)),
    Question("prismatic-flow", "rated flow of the slide's valve", "m^3/s", None, (ARM,)),
    Question("rated-drop", "pressure drop of the rated flow, over both lands", "Pa", "70 bar"),
    Question("full-scale", "command for full opening", "V", "10 V"),
    Question("stroke-time", "time of the spool from null to full opening", "s", "10 ms"),
    Question("supply", "supply pressure", "Pa"),
    Question("iso-vg", "grade of the oil: ISO VG", "", "46"),
    Question("resolution", "step of the position sensor", "", None, AXES),
    Question("noise", "noise of the position sensor, rms", "", None, AXES, may_be_zero=True),
    Question("rotary-resolution", "step of the hub's position sensor", "rad", "0.005 deg", (ARM,)),
    Question("rotary-noise", "its noise, rms", "rad", "0.002 deg", (ARM,), may_be_zero=True),
    Question("prismatic-resolution", "step of the slide's position sensor", "m", "25 um", (ARM,)),
    Question("prismatic-noise", "its noise, rms", "m", "10 um", (ARM,), may_be_zero=True),
    Question(
        "deflection-range", "range of the deflection sensor at the tip, either way (0 mm: none)", "m", "0 mm", (ARM,), may_be_zero=True
    ),
    Question("deflection-resolution", "its step", "m", "20 um", (ARM,)),
    Question("deflection-noise", "its noise, rms", "m", "20 um", (ARM,), may_be_zero=True),
)


def of_kind(kind: str) -> list[Question]:
    return [question for question in QUESTIONS if kind in question.kinds]


def answers(arguments: argparse.Namespace, kind: str, ask: Callable[[str], str] | None) -> tuple[dict[str, str], frozenset[str]]:
    """Every answer as the user writes it, checked, and the keys of those that were not given and stand at their default. Asked for with
    `ask` where a flag is missing. UsageError names all flags that are wrong or missing at once."""
    found: dict[str, str] = {}
    assumed: set[str] = set()
    wrong: list[str] = []
    for question in of_kind(kind):
        given = getattr(arguments, question.key)
        if given is None and ask is not None:
            given = _asked(question, kind, found, ask)
        if given is None and question.default is not None:
            assumed.add(question.key)
            given = question.default
        problem = "is missing" if given is None else _problem(question, kind, found, given)
        if problem:
            wrong.append(f"--{question.flag} {problem}")
        else:
            found[question.key] = str(given)
    if wrong:
        example = "e.g. --bore '16 mm' --rated-flow '10 l/min' --supply '70 bar'"
        advice = f"Give them with units, {example}; in a terminal `longreach new-rig {arguments.name} --kind {kind}` asks for each."
        raise UsageError("; ".join(wrong), where="new-rig", next_step=advice)
    return found, frozenset(assumed)


def _asked(question: Question, kind: str, found: Mapping[str, str], ask: Callable[[str], str]) -> str | None:
    """Asks until the answer can be read; an empty one takes the default."""
    while True:
        default = f" [{question.default}]" if question.default else ""
        given = ask(f"{question.text}{default}: ").strip()
        if not given and question.default:
            return None
        problem = _problem(question, kind, found, given) if given else "is needed"
        if not problem:
            return given
        print(f"  {problem}")


def _problem(question: Question, kind: str, found: Mapping[str, str], given: str) -> str:
    """Why an answer cannot be taken beside those before it; empty for a good one."""
    unit = question.unit or {"resolution": "", "noise": ""}.get(question.key, "word")
    if unit == "word":
        return ""
    try:
        value = number(given, unit or ("rad" if kind == ROTARY else "m"))
    except LongreachError as error:
        return f"{given!r}: {error.refusal.what}. {error.refusal.next_step}".rstrip(". ")
    if value > _BEYOND_ANY_MACHINE:
        return f"{given!r}: no machine has that"
    if question.key == "rod" and "bore" in found and value >= number(found["bore"], "m"):
        return f"{given!r}: must be thinner than the bore, {found['bore']}"
    return "" if value > 0.0 or question.may_be_zero else f"{given!r}: must be above 0"


def number(given: str, unit: str) -> float:
    """The answer in `unit`; UnitError also for a bare number where a unit is wanted, and for what is negative."""
    from config.units import to_si, written_unit

    if unit and not written_unit(given):
        raise UnitError("a unit is missing", value=repr(given), next_step=f"Write it with one, e.g. {_EXAMPLES.get(unit, f'in {unit}')}.")
    value = to_si(given, unit)
    if value < 0.0:
        raise UnitError("must not be negative", value=repr(given), next_step="Give its size.")
    return value


def grade(given: str) -> int:
    """The number of `46`, `VG 46` or `ISO VG 46`."""
    words = given.upper().replace("ISO", " ").replace("VG", " ").split()
    if len(words) != 1 or not words[0].isdigit():
        advice = "Give the number after ISO VG, e.g. 46."
        raise UsageError("this is no grade of oil", value=repr(given), where="--iso-vg", next_step=advice, mend={"--iso-vg": "46"})
    return int(words[0])


def choose_kind(given: str | None, ask: Callable[[str], str] | None) -> str:
    kinds: Sequence[str] = (CYLINDER, ROTARY, ARM)
    while given not in kinds:
        if ask is None:
            advice, mend = f"Add --kind {CYLINDER}.", {"--kind": CYLINDER}
            raise UsageError("--kind is missing", limit=" or ".join(kinds), where="new-rig", next_step=advice, mend=mend)
        if given is not None:
            print(f"  {given!r} is none of them{nearest_text(given, kinds)}")
        given = ask(f"kind of rig ({' or '.join(kinds)}) [{CYLINDER}]: ").strip() or CYLINDER
    return str(given)
