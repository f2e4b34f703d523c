"""Walking the schema: which class, field, unit and range stand behind a key of a file.

The loader needs it to give pydantic's errors a place, overrides to check their keys, and the reference to list them all.
"""

from __future__ import annotations

import types
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import Tag
from pydantic.fields import FieldInfo

from config.schema.section import Section, is_inferred

Key = str | int


@dataclass(frozen=True, slots=True)
class SchemaKey:
    """A key of a file and what the schema says about it. `field` is None where no field is declared (a name in a mapping)."""

    path: tuple[Key, ...]
    annotation: Any
    field: FieldInfo | None
    section: type[Section] | None  # the section that holds the key


def place_of_error(annotation: Any, loc: Sequence[Key]) -> SchemaKey:
    """The place of a pydantic error location, from which the tags of unions and validator labels are taken out."""
    return _walk(SchemaKey((), annotation, None, None), list(loc), None)


def place_of_path(annotation: Any, path: Sequence[Key], plain: Any) -> SchemaKey:
    """The place of a key path in a file with the content `plain` (which chooses the members of unions)."""
    return _walk(SchemaKey((), annotation, None, None), list(path), plain)


def _walk(place: SchemaKey, rest: list[Key], plain: Any) -> SchemaKey:
    annotation = bare(place.annotation)
    if members := union_members(annotation):
        if plain is not None:
            return _walk(SchemaKey(place.path, member_for(annotation, plain), place.field, place.section), rest, plain)
        if len(members) == 1:
            return _walk(SchemaKey(place.path, members[0][1], place.field, place.section), rest, None)
        if rest:
            chosen = next((member for tag, member in members if tag == rest[0]), Any)
            return _walk(SchemaKey(place.path, chosen, place.field, place.section), rest[1:], None)
    if not rest:
        return SchemaKey(place.path, annotation, place.field, place.section)
    return _enter(place, annotation, rest, plain)


def _enter(place: SchemaKey, annotation: Any, rest: list[Key], plain: Any) -> SchemaKey:
    key = rest[0]
    inner = (
        plain[key] if isinstance(plain, dict) and key in plain else plain[key] if isinstance(plain, list) and isinstance(key, int) else None
    )
    path = (*place.path, key)
    if isinstance(annotation, type) and issubclass(annotation, Section):
        field = fields_of(annotation).get(str(key))
        below = SchemaKey(path, field.annotation if field else None, field, annotation)
        return _walk(below, rest[1:], inner) if field else below
    if get_origin(annotation) is dict:
        remaining = [] if rest[1:] == ["[key]"] else rest[1:]
        return _walk(SchemaKey(path, get_args(annotation)[1], None, place.section), remaining, inner)
    if get_origin(annotation) in (tuple, list) and isinstance(key, int):
        arguments = [item for item in get_args(annotation) if item is not Ellipsis]
        item = arguments[key] if len(arguments) > 1 and key < len(arguments) else arguments[0]
        return _walk(SchemaKey(path, item, place.field, place.section), rest[1:], inner)
    return SchemaKey(place.path, annotation, place.field, place.section)


def fields_of(section: type[Section]) -> dict[str, FieldInfo]:
    """Key in the file → field, in the order of the class; keys the loader infers are left out."""
    return {field.alias or name: field for name, field in section.model_fields.items() if not is_inferred(field)}


def bare(annotation: Any) -> Any:
    """The annotation without Annotated[...]."""
    while get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    return annotation


def union_members(annotation: Any) -> list[tuple[str, Any]]:
    """(tag, member) of a union, None left out; empty for anything else. The tag is what pydantic puts into an error's location."""
    annotation = bare(annotation)
    if get_origin(annotation) not in (Union, types.UnionType):
        return []
    return [(_tag(member), bare(member)) for member in get_args(annotation) if member is not types.NoneType]


def _tag(member: Any) -> str:
    for extra in get_args(member)[1:] if get_origin(member) is Annotated else ():
        if isinstance(extra, Tag):
            return extra.tag
    member = bare(member)
    if isinstance(member, type) and issubclass(member, Section):
        return next(iter(choices(member).values()), (member.__name__,))[0]
    return str(getattr(member, "__name__", member))


def choices(section: type[Section]) -> dict[str, tuple[str, ...]]:
    """The required keys of a section with a fixed set of words, such as `kind`: these choose the member of a union."""
    return {
        field.alias or name: tuple(map(str, get_args(bare(field.annotation))))
        for name, field in section.model_fields.items()
        if get_origin(bare(field.annotation)) is Literal and field.is_required() and name != "longreach"
    }


def member_for(annotation: Any, plain: Any) -> Any:
    """The member of a union whose choosing key has the value found in `plain`; the first member when none has."""
    members = [member for _, member in union_members(annotation)]
    return next((member for member in members if _fits(member, plain)), members[0])


def _fits(member: Any, plain: Any) -> bool:
    if not (isinstance(member, type) and issubclass(member, Section) and isinstance(plain, dict)):
        return False
    return all(plain.get(key) in words for key, words in choices(member).items())


def limits(field: FieldInfo | None) -> tuple[float | None, float | None]:
    """Lower and upper limit of a number, inclusive or not."""
    low = high = None
    for extra in field.metadata if field else ():
        low = next((value for value in (getattr(extra, "ge", None), getattr(extra, "gt", None)) if value is not None), low)
        high = next((value for value in (getattr(extra, "le", None), getattr(extra, "lt", None)) if value is not None), high)
    return low, high
