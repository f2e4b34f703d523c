"""Options of a driver drawn at random from its own schema: half of them only such as it allows, else anything here and there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal, get_args, get_origin

from hypothesis import strategies as st
from pydantic.fields import FieldInfo

from config.schema.model_fields import bare, fields_of, limits
from config.schema.section import Section

_WRONG = st.one_of(st.integers(-5, 70_000), st.floats(-10, 1e6), st.sampled_from(["", "one", "5 kg", "-1", "1e9", "true"]), st.none())
Special = Mapping[str, st.SearchStrategy[Any]]


@st.composite
def options(draw: Callable[[Any], Any], schema: type[Section], fixed: Mapping[str, Any], special: Special) -> dict[str, Any]:
    """Every field is left out or drawn within its limits (in SI, as bare numbers); in every other line, once in ten, it is anything.

    `fixed` stays as it is.
    """
    found = dict(fixed)
    careless = draw(st.booleans())
    for key, field in fields_of(schema).items():
        if key in fixed or (not field.is_required() and draw(st.booleans())):
            continue
        if careless and draw(st.integers(0, 9)) == 0:
            found[key] = draw(_WRONG)
        else:
            found[key] = draw(special[key] if key in special else _allowed(field))
    return found


def _allowed(field: FieldInfo) -> st.SearchStrategy[Any]:
    kind = bare(field.annotation)
    kinds = [each for each in get_args(kind) if each is not type(None)] if get_origin(kind) not in (None, Literal, dict) else [kind]
    kind = kinds[0]
    if get_origin(kind) is Literal:
        return st.sampled_from(get_args(kind))
    if kind is bool:
        return st.booleans()
    low, high = limits(field)
    if kind is int:
        return st.integers(int(low if low is not None else -(2**31)), int(high if high is not None else 2**31))
    if kind is float:
        return st.floats(low if low is not None else -1e6, high if high is not None else 1e6)
    raise NotImplementedError(f"{field.annotation} needs a strategy of its own")
