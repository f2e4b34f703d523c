"""Whatever is done to a rig file, the loader answers with a rig or with a ConfigError that names a place in it."""

from __future__ import annotations

import re

from hypothesis import example, given, settings
from hypothesis import strategies as st

from config.errors import ConfigError, Refusal
from config.loading.load import rig_from_text
from config.schema.rig import Rig
from tests.support.config.small_rig import SMALL

PIECES = st.sampled_from(
    [
        "",
        " ",
        "\n",
        ":",
        "- ",
        "{",
        "}",
        "[",
        "]",
        "#",
        "'",
        '"',
        "&a",
        "*a",
        "!x ",
        "|",
        ">",
        "? ",
        "~",
        "1e999",
        "\t",
        "axis",
        "%",
        "<<: 3\n",
    ]
)
PLACE = re.compile(r"x\.yaml:\d+:\d+: ")


@settings(max_examples=400, deadline=None)
@given(
    edits=st.lists(st.tuples(st.integers(0, len(SMALL)), st.integers(0, 12), PIECES | st.text(max_size=4)), min_size=1, max_size=3),
)
@example(edits=[(0, len(SMALL), "longreach: rig/1\njoints: 3\nservo: []\nsignals: x\ndevices: {1: 2}\noutputs: ~\narm: 1\nplant: [1]\n")])
@example(
    edits=[
        (
            0,
            len(SMALL),
            "longreach: rig/1\njoints: {axis: 3}\nservo: {axis: []}\nsignals: {axis.position: 3}\nplant: {joints: 2, effects: 3}\n",
        )
    ]
)
def test_no_edit_of_a_rig_file_makes_the_loader_fail_otherwise(edits: list[tuple[int, int, str]]) -> None:
    text = SMALL
    for start, length, piece in edits:
        text = text[:start] + piece + text[start + length :]
    lines = sum(map(text.count, "\n\r\x85\u2028\u2029")) + 2
    for refusal in problems_of(text):
        assert PLACE.match(refusal.text()), refusal.text()
        assert 1 <= int(refusal.where.split(":")[1]) <= lines


def problems_of(text: str) -> tuple[Refusal, ...]:
    try:
        assert isinstance(rig_from_text(text, "x.yaml"), Rig)
    except ConfigError as error:
        return error.problems
    return ()
