"""docs/method/architecture.md keeps its word: the picture is that of the imports, and the reader's test leads to paths that exist."""

from __future__ import annotations

import re

import pytest

from tests.docs.pages import CHECKOUT, DOCS
from tests.docs.rooms_picture import PICTURE, picture

PAGE = DOCS / "method" / "architecture.md"
QUESTIONS = 20


def answers() -> list[tuple[str, str]]:
    """Question and first path of every row of the reader's test."""
    text = PAGE.read_text().partition("## The reader's test")[2].partition("\n## ")[0]
    rows = [line.strip("|").split("|") for line in text.splitlines() if line.startswith("|")][2:]
    return [(row[0].strip(), path) for row in rows for path in re.findall(r"`([^`]+)`", row[1])]


def test_the_picture_is_that_of_the_imports() -> None:
    assert PICTURE.read_text() == picture(), "run `make docs`"


def test_enough_questions() -> None:
    assert len({question for question, _ in answers()}) >= QUESTIONS


@pytest.mark.parametrize(("question", "path"), answers())
def test_an_answer_exists(question: str, path: str) -> None:
    assert (CHECKOUT / path).exists(), f"{question} {path}"


@pytest.mark.parametrize("path", sorted(set(re.findall(r"`((?:\w+/)+[\w.]*)`", PAGE.read_text()))))
def test_a_path_named_on_the_page_exists(path: str) -> None:
    assert (CHECKOUT / path).exists(), path
