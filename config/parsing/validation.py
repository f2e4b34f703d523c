"""pydantic's errors → problems that a person with the file open can act on: the place, the key, the value, the limit, the nearest key."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from config.errors import Mend, UnitError
from config.parsing.nearest import nearest, nearest_text
from config.parsing.problems import Problem
from config.parsing.yaml_tree import YamlTree, dotted
from config.schema.model_fields import SchemaKey, choices, fields_of, limits, place_of_error, union_members
from config.schema.section import units_of
from config.units import UNKNOWN, from_si, to_si, units_like, written_unit

_EXPECTED = {
    "model_type": "a section (key: value lines)",
    "model_attributes_type": "a section (key: value lines)",
    "dict_type": "a section (key: value lines)",
    "tuple_type": "a list [a, b, ...]",
    "list_type": "a list [a, b, ...]",
    "string_type": "a text",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "float_parsing": "a number",
    "date_type": "a day, YYYY-MM-DD",
    "date_parsing": "a day, YYYY-MM-DD",
    "date_from_datetime_parsing": "a day, YYYY-MM-DD",
}
_LONGEST_SHOWN = 120
_OUT_OF_RANGE = {"greater_than_equal", "greater_than", "less_than_equal", "less_than"}


def validated(annotation: Any, tree: YamlTree) -> tuple[Any, list[Problem]]:
    """The file's content as a model, or None and every problem the schema finds."""
    try:
        return TypeAdapter(annotation).validate_python(tree.plain), []
    except ValidationError as errors:
        details = errors.errors(include_url=False)
        meant = {_meant(place_of_error(annotation, error["loc"])) for error in details if error["type"] == "extra_forbidden"}
        told = [error for error in details if error["type"] != "missing" or place_of_error(annotation, error["loc"]).path not in meant]
        return None, [_problem(error, annotation, tree) for error in told]


def _problem(error: ErrorDetails, annotation: Any, tree: YamlTree) -> Problem:
    place = place_of_error(annotation, error["loc"])
    kind = error["type"]
    if kind in _OUT_OF_RANGE:
        return _out_of_range(place, tree)
    describe: Callable[[ErrorDetails, SchemaKey, YamlTree], Problem] = {
        "extra_forbidden": _unknown_key,
        "missing": _missing_key,
        "choice": _wrong_choice,
        "union_tag_invalid": _wrong_choice,
        "union_tag_not_found": _wrong_choice,
        "literal_error": _wrong_word,
        "string_pattern_mismatch": _wrong_name,
        "unit": _wrong_quantity,
        "against": _against_another,
    }.get(kind, _wrong_value)
    return describe(error, place, tree)


def _meant(place: SchemaKey) -> tuple[str | int, ...]:
    """The key a misspelt key stands for: it is not reported as missing as well."""
    known = fields_of(place.section) if place.section else {}
    return (*place.path[:-1], nearest(str(place.path[-1]), known) or "")


def _unknown_key(error: ErrorDetails, place: SchemaKey, tree: YamlTree) -> Problem:
    key = str(place.path[-1])
    known = list(fields_of(place.section)) if place.section else []
    section = dotted(place.path[:-1]) or "the file"
    what = f"{dotted(place.path)} is not a key here{nearest_text(key, known)}"
    return tree.problem(place.path, what, of_key=True, next_step=f"Keys of {section}: {', '.join(known)}.")


def _missing_key(error: ErrorDetails, place: SchemaKey, tree: YamlTree) -> Problem:
    key, section = place.path[-1], dotted(place.path[:-1]) or "the file"
    if isinstance(key, int):
        return tree.problem(
            place.path[:-1], f"{section} must have at least {key + 1} entries", value=f"got {_shown(tree.value(place.path[:-1]))}"
        )
    description = place.field.description if place.field and place.field.description else ""
    unit, allowed = _unit(place), _allowed(place, "")
    parts = [part for part in (description, f"in {unit}" if unit else "", allowed) if part]
    next_step = f"Add {key}: ... ({'; '.join(parts)})." if parts else f"Add {key}: ..."
    return tree.problem(place.path, f"{section} needs the key {key!r}", of_key=True, next_step=next_step)


def _wrong_choice(error: ErrorDetails, place: SchemaKey, tree: YamlTree) -> Problem:
    members = [member for _, member in union_members(place.annotation)]
    key = str(error.get("ctx", {}).get("key", error.get("ctx", {}).get("discriminator", ""))).strip("'")
    words = [word for member in members for word in choices(member).get(key, ())]
    if key not in fields_of(members[0]):
        unknown = tree.problem(place.path, f"{dotted(place.path)}: what it is for cannot be told from its name", of_key=True)
        return replace(unknown, follows=True)
    path = (*place.path, key)
    if not isinstance(error["input"], dict):
        return tree.problem(place.path, f"{dotted(place.path)} must be {_EXPECTED['model_type']}", value=_shown(error["input"]))
    if key not in error["input"]:
        what = f"{dotted(place.path) or 'the file'} needs the key {key!r}"
        return tree.problem(path, what, of_key=True, next_step=f"Choose one of: {', '.join(words)}.")
    return _not_a_word(path, error["input"][key], words, tree)


def _wrong_word(error: ErrorDetails, place: SchemaKey, tree: YamlTree) -> Problem:
    allowed = [word.strip("'") for word in error["ctx"]["expected"].replace(" or ", ", ").split(", ")]
    return _not_a_word(place.path, error["input"], allowed, tree)


def _not_a_word(path: tuple[str | int, ...], value: Any, words: list[str], tree: YamlTree) -> Problem:
    hint = nearest_text(str(value), words)
    listed = f"Allowed: {', '.join(words)}." if not hint or len(words) <= 12 else ""
    return tree.problem(path, f"{dotted(path)} cannot be {_shown(value)}{hint}", next_step=listed)


def _wrong_name(error: ErrorDetails, place: SchemaKey, tree: YamlTree) -> Problem:
    is_key = error["loc"][-1] == "[key]"
    what = f"{dotted(place.path)} is not a usable name"
    advice = "Use lower-case letters, digits and underscores, a letter first, 64 in all."
    return tree.problem(place.path, what, of_key=is_key, value=_shown(error["input"]), next_step=advice)


def _wrong_quantity(error: ErrorDetails, place: SchemaKey, tree: YamlTree) -> Problem:
    index = error.get("ctx", {}).get("index")
    path = place.path if index is None else (*place.path, index)
    what = f"{dotted(path)}: {error['msg']}"
    next_step = str(error.get("ctx", {}).get("next_step", ""))
    if error["msg"] == UNKNOWN:
        next_step = f"{_nearest_unit(place, tree.value(path))}{next_step}"
    allowed = _allowed(place, "")
    if allowed:
        next_step = f"{next_step} Allowed: {allowed}.".strip()
    return tree.problem(path, what, value=_shown(tree.value(path)), next_step=next_step, mend=_what_fits(path, place, tree))


def _nearest_unit(place: SchemaKey, written: Any) -> str:
    known = [each for stored in units_of(place.field) for each in units_like(stored)] if place.field else []
    meant = nearest(written_unit(written), known)
    return f"Nearest is {meant!r}. " if meant else ""


def _what_fits(path: tuple[str | int, ...], place: SchemaKey, tree: YamlTree) -> Mend:
    """What does not fit; what was meant, where that is known (a decimal comma)."""
    written = tree.value(path)
    units = units_of(place.field) if place.field else ()
    try:
        to_si(written, units[0]) if isinstance(written, str) and len(units) == 1 else None
    except UnitError as error:
        return {dotted(path): error.refusal.mend.get(written)}
    return {}


def _out_of_range(place: SchemaKey, tree: YamlTree) -> Problem:
    written = tree.value(place.path)
    limit, mend = _allowed(place, written_unit(written)), _nearest_bound(place, written)
    return tree.problem(place.path, f"{dotted(place.path)} is out of range", value=_with_unit(written, place), limit=limit, mend=mend)


def _nearest_bound(place: SchemaKey, written: Any) -> Mend:
    low, high = limits(place.field)
    unit = _unit(place, written_unit(written))
    try:
        value = to_si(written, unit)
    except UnitError:
        return {}
    bound = low if low is not None and value < low else high
    return {} if bound is None else {dotted(place.path): f"{bound:.6g} {unit}".rstrip()}


def _against_another(error: ErrorDetails, place: SchemaKey, tree: YamlTree) -> Problem:
    other = tree.value((*place.path[:-1], error["ctx"]["other"]))
    limit = error["ctx"]["stored"] if other is None else _with_unit(other, place)
    return tree.problem(place.path, f"{dotted(place.path)}: {error['msg']}", value=_with_unit(tree.value(place.path), place), limit=limit)


def _with_unit(written: Any, place: SchemaKey) -> str:
    """As it is written; a bare number with the unit in which it is taken."""
    unit = "" if isinstance(written, list) or written_unit(written) else _unit(place)
    return f"{written} {unit}".rstrip()


def _wrong_value(error: ErrorDetails, place: SchemaKey, tree: YamlTree) -> Problem:
    if error["loc"][-1:] == ("[key]",):
        return _wrong_key(error, place, tree)
    shown = _shown(tree.value(place.path))
    if error["type"] in _EXPECTED:
        problem = tree.problem(place.path, f"{dotted(place.path)} must be {_EXPECTED[error['type']]}", value=f"got {shown}")
        place_unknown = len(_unit(place).split(" or ")) > 1 and error["type"] == "float_parsing"
        return replace(problem, follows=place_unknown)
    if error["type"] in ("too_long", "too_short"):
        bound = "at most" if error["type"] == "too_long" else "at least"
        count = error["ctx"]["max_length" if error["type"] == "too_long" else "min_length"]
        problem = tree.problem(place.path, f"{dotted(place.path)} must have {bound} {count} entries", value=f"got {shown}")
        return replace(problem, follows=bound == "at least" and _has_as_many(tree.value(place.path), count))
    message = error["msg"].removeprefix("Value error, ")
    return tree.problem(place.path, f"{dotted(place.path) or 'the file'}: {message}", value=f"got {shown}" if len(shown) < 60 else "")


def _has_as_many(written: Any, least: int) -> bool:
    """Of too few entries: pydantic counts those that are right."""
    return isinstance(written, (list, dict)) and len(written) >= least


def _wrong_key(error: ErrorDetails, place: SchemaKey, tree: YamlTree) -> Problem:
    wanted = _EXPECTED.get(error["type"], error["msg"])
    what = f"{dotted(place.path[:-1])}: the key {_shown(place.path[-1])} must be {wanted}"
    return tree.problem(place.path, what, of_key=True)


def _unit(place: SchemaKey, written: str = "") -> str:
    """The stored unit of a quantity; where it depends on the place, the one that fits what the user wrote, or all of them."""
    units = units_of(place.field) if place.field else ()
    fitting = [unit for unit in units if written and _convertible(written, unit)]
    return fitting[0] if fitting else " or ".join(units)


def _convertible(written: str, unit: str) -> bool:
    try:
        to_si(f"1 {written}", unit)
    except UnitError:
        return False
    return True


def _allowed(place: SchemaKey, written: str) -> str:
    """The allowed range in the unit the user wrote and in the stored one; empty where there is no limit."""
    low, high = limits(place.field)
    unit = _unit(place, written)
    stored = _range_text(low, high, unit)
    if not stored or not written or written == unit or not _convertible(written, unit):
        return stored
    own = [from_si(limit, unit, written) if limit is not None else None for limit in (low, high)]
    return f"{_range_text(own[0], own[1], written)}, which is {stored}"


def _range_text(low: float | None, high: float | None, unit: str) -> str:
    suffix = f" {unit}" if unit else ""
    if low is not None and high is not None:
        return f"{low:.6g} to {high:.6g}{suffix}"
    if low is not None:
        return f"at least {low:.6g}{suffix}"
    return f"at most {high:.6g}{suffix}" if high is not None else ""


def _shown(value: Any) -> str:
    shown = "nothing" if value is None else repr(value)
    return shown if len(shown) <= _LONGEST_SHOWN else f"{shown[:_LONGEST_SHOWN]}…"
