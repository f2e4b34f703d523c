"""libyaml's parser gives the nodes of PyYAML's own, also of files that somebody is still editing; messages are those of the latter."""

from __future__ import annotations

import random

import pytest
import yaml

from config.errors import ConfigError
from config.loading.shipped import shipped
from config.parsing import yaml_tree
from config.parsing.yaml_tree import parse

pytestmark = pytest.mark.skipif(not yaml.__with_libyaml__, reason="PyYAML was built without libyaml")
_TEXTS = [path.read_text(encoding="utf-8") for kind in ("rigs", "maneuvers", "maps") for path in shipped(kind).values()]
_SIGNS = " \n:-[]{},#'\"!%@`|>&*é0a~.\\?\t"


def _rows(node: yaml.Node) -> list[tuple[object, ...]]:
    """Every node with what the house asks of it: kind, text, beginning and end."""
    start, end = node.start_mark, node.end_mark
    own = (node.tag, start.line, start.column, start.index, end.line, end.column, end.index, getattr(node, "flow_style", None))
    inner = [part for pair in node.value for part in pair] if isinstance(node, yaml.MappingNode) else node.value
    below = [] if isinstance(inner, str) else [row for part in inner for row in _rows(part)]
    return [(*own, inner if isinstance(inner, str) else len(inner)), *below]


def _rows_by_own_parser(text: str) -> list[tuple[object, ...]] | str:
    try:
        root = yaml_tree._CoreLoader(text).get_single_node()
    except yaml.YAMLError:
        return "refused"
    return _rows(root) if root is not None else []


def _rows_as_used(text: str) -> list[tuple[object, ...]] | str:
    try:
        root = yaml_tree._root(text)
    except yaml.YAMLError:
        return "refused"
    return _rows(root) if root is not None else []


@pytest.mark.parametrize("text", _TEXTS)
def test_shipped_files_give_the_same_nodes(text: str) -> None:
    assert _rows_as_used(text) == _rows_by_own_parser(text)
    assert yaml_tree._FastLoader(text).get_single_node() is not None


def _damaged(text: str, numbers: random.Random) -> str:
    letters = list(text[: numbers.randint(200, 1500)])
    for _ in range(numbers.randint(1, 4)):
        place = numbers.randrange(len(letters))
        letters[place : place + numbers.randint(0, 1)] = numbers.choice(_SIGNS)
    return "".join(letters) + "\n"


@pytest.mark.parametrize("seed", range(10))
def test_damaged_files_too(seed: int) -> None:
    numbers = random.Random(seed)
    read = 0
    for _ in range(80):
        text = _damaged(numbers.choice(_TEXTS), numbers)
        expected = _rows_by_own_parser(text)
        assert _rows_as_used(text) == expected, text
        read += expected != "refused"
    assert read > 10


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("a: [1, 2\n", "f.yaml:2:1", "expected ',' or ']', but got '<stream end>'"),
        ("a: &x 1\nb: 2\n", "f.yaml:1:4", "anchors and aliases (& and *) are not used here"),
        ("a: 1\nb: \x07\n", "f.yaml:2:4", "character '\\x07' is not allowed"),
    ],
)
def test_what_cannot_be_read_is_told_with_its_place(text: str, place: str, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse(text, "f.yaml")
    assert place in str(caught.value)
    assert message in str(caught.value)
