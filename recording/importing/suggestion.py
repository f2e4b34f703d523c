"""Proposes an import map from a table's column names: what each column probably is, in which unit, and why it was taken or left out."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from config.errors import UnitError
from config.units import to_si
from recording.format.fields import Field
from recording.format.layout import CycleLayout
from recording.importing.table import SourceTable

# Words of people who name columns, English and German, by the field of the log they mean; the first that fits counts.
_WORDS: tuple[tuple[str, str], ...] = (
    ("t_s", "time t ts timestamp zeit sample clock elapsed"),
    ("pressure_a_Pa", "pa p1 p_a pressurea piston chambera porta drucka druck1 kolbenseite kammera"),
    ("pressure_b_Pa", "pb p2 p_b pressureb annulus rodside chamberb portb druckb druck2 stangenseite kammerb"),
    ("supply_pressure_Pa", "ps psupply supply pump pp versorgungsdruck systemdruck pumpendruck druckp pumpe"),
    ("return_pressure_Pa", "pt pr preturn return tank rucklauf ruecklauf rucklaufdruck ruecklaufdruck tankdruck druckt"),
    ("supply_temperature_C", "temperature temp oil temperatur oltemperatur oeltemperatur"),
    ("reference", "ref reference setpoint desired demand soll sollwert sollweg"),
    ("command_V", "u command cmd valve voltage volt input spool drive xv ventil ventilspannung spannung stellgrosse"),
    ("velocity", "velocity vel speed v rate omega geschwindigkeit"),
    ("position", "position pos x y q angle theta stroke displacement extension length ist istweg weg kolbenweg hub winkel"),
)
_UNIT = re.compile(r"[\[(]\s*([^\])]+?)\s*[\])]\s*$|[_ ]((?:k|M|m|u)?(?:s|m|V|Pa|bar|psi|rad|deg|in|ft|degC|C|mrad))(?:$)", re.IGNORECASE)
# `vel_mm_s`, `acc_mps2`; but `time_in_s` is no inches per second
_RATE = re.compile(r"[_ ]([mck]?m|in(?=_?p|/)|ft|deg|m?rad|[kM]?Pa|bar|psi|V)(?:_?per_?|p|[_/])s(?:ec)?(?:\^?(2))?$", re.IGNORECASE)
_RENAMED = {"C": "degC", "°C": "degC", "°": "deg", "sec": "s", "grad": "deg"}
_KINDS = {"s": "t_s", "Pa": "pressure", "V": "command_V", "degC": "temperature", "m": "position", "rad": "position"}
_KINDS |= {"m/s": "velocity", "rad/s": "velocity"}


@dataclass(frozen=True, slots=True)
class Guess:
    """One column of the table: the field of the log it is taken for (empty: none), its unit, and the reason."""

    source: str
    field: str
    unit: str
    why: str


def suggested_map(table: SourceTable, name: str, rig: str, joints: dict[str, str]) -> str:
    """The text of a map file: every column once, under `columns` or `ignored`, each with the reason. `joints`: name → rotary or linear."""
    guesses = guess(table, joints)
    taken = [one for one in guesses if one.field]
    no_time = all(one.field != "t_s" for one in taken)
    lines = [
        "longreach: map/1",
        f"name: {re.sub(r'[^a-z0-9_]', '_', name.lower()) if name[:1].isalpha() else 'table'}",
        "description: proposed from the column names; look at every line before you trust it",
        *([f"rig: {rig}"] if rig else []),
        f"joints: {{{', '.join(f'{joint}: {motion}' for joint, motion in joints.items())}}}",
        "columns:",
        *(["  # t_s: {source: '', unit: s}  # no column's name says that it is the time: name it here"] if no_time else []),
        *(f"  {one.field}: {{source: {_quoted(one.source)}{f', unit: {one.unit}' if one.unit else ''}}}  # {one.why}" for one in taken),
    ]
    left = [one for one in guesses if not one.field]
    if left:
        lines += ["ignored:", *(f"  - {_quoted(one.source)}  # {one.why}" for one in left)]
    return "\n".join(lines) + "\n"


def guess(table: SourceTable, joints: dict[str, str]) -> list[Guess]:
    """What every column of the table is taken for, in the table's order; no field of the log twice."""
    fields = {field.name: field for field in CycleLayout(tuple(joints), list(joints.values())).fields}
    taken: set[str] = set()
    found = []
    for source in table.columns:
        one = _one(source, fields, joints) if source not in table.dates else Guess(source, "t_s", "s", "dates or times of day, as seconds")
        if one.field and one.field in taken:
            one = Guess(source, "", "", f"{one.field} is taken already")
        taken.add(one.field)
        found.append(one)
    return found


def _one(source: str, fields: dict[str, Field], joints: dict[str, str]) -> Guess:
    if source in fields:
        return Guess(source, source, "", "the log's own name")
    bare, unit = _without_unit(source)
    words = _words(bare)
    joint = next((name for name in joints if name in words), next(iter(joints)))
    field = _meant(words, unit)
    whole = field if field in ("", "t_s") else f"{joint}.{field}"
    if not whole:
        return Guess(source, "", "", "nothing in its name says what it is")
    own = fields[whole].unit
    if unit and not _converts(unit, own):
        return Guess(source, "", "", f"by its name {whole}, but {unit} is no unit of it ({own})")
    why = f"by its name{'' if unit else f'; no unit in it, {own} assumed: check'}"
    return Guess(source, whole, unit or own, why)


def _meant(words: Sequence[str], unit: str) -> str:
    kind = next((kind for si, kind in _KINDS.items() if unit and _converts(unit, si)), "")
    joined = {"".join(pair) for pair in pairwise(words)} | set(words)
    fitting = [field for field, known in _WORDS if joined & set(known.split()) and (not kind or kind in field or field in ("reference",))]
    return fitting[0] if fitting else (kind if kind in ("t_s", "command_V", "position", "velocity") else "")


def _without_unit(source: str) -> tuple[str, str]:
    """Name and unit of `Druck A [bar]`, `pos_mm`, `vel_mm_s`, `u (V)`; the unit empty where none can be read."""
    rate = _RATE.search(source)
    if rate:
        return source[: rate.start()], f"{rate[1]}/s{'^2' if rate[2] else ''}"
    found = _UNIT.search(source)
    if not found or (found[2] and _converts(found[2], "s") and not _names_time(source)):
        return source, ""
    text = found[1] or found[2]
    unit = _RENAMED.get(text, text)
    known = any(_converts(unit, si) for si in (*_KINDS, "m/s^2"))
    return (source[: found.start()], unit) if known else (source, "")


def _names_time(source: str) -> bool:
    """A bare `_s` may be the end of another unit, or stand for the supply or a set point; in brackets it is seconds."""
    return bool(set(_words(source)) & set(dict(_WORDS)["t_s"].split()))


def _words(name: str) -> list[str]:
    """`rodPos_A` → rod, pos, a; `Rücklaufdruck` → rucklaufdruck."""
    plain = unicodedata.normalize("NFKD", name.replace("ß", "ss")).encode("ascii", "ignore").decode()
    return re.findall(r"[a-z]+\d*|\d+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", plain).lower())


def _converts(unit: str, si: str) -> bool:
    try:
        to_si(f"1 {unit}", si)
    except UnitError:
        return False
    return True


def _quoted(source: str) -> str:
    return source if re.fullmatch(r"[A-Za-z][\w.]*", source) else '"' + source.replace('"', '\\"') + '"'
