"""The reference pages say what the schema says."""

from __future__ import annotations

import pytest

from config.reference import REFERENCE, pages


@pytest.mark.parametrize("name", sorted(pages()))
def test_committed_pages_are_those_of_the_schema(name: str) -> None:
    assert (REFERENCE / name).read_text(encoding="utf-8") == pages()[name], "run `python -m config.reference` and commit the result"


def test_a_key_is_told_with_unit_range_default_and_meaning() -> None:
    page = pages()["rig.md"]
    assert "| `rate` | cycles per second | Hz | number, 10 to 2000 | 1000 |" in page
    assert "| `gain` | proportional gain, DC gain of the whole compensator | V/rad | number, -2000 to 2000 | **required** |" in page
    assert "| `kind` | geometry of the arm |  | `rotary_prismatic`, `single_axis` | **required** |" in page
    assert "`motion` | from the joint" not in page  # what the loader fills in is not offered as a key
