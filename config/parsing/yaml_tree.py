"""YAML text → plain data in which every value still knows its line and column.

PyYAML composes the node tree; the scalars are read by the core schema of YAML 1.2, because YAML 1.1 turns `off` into false,
`12:30` into 750 and leaves `1e5` a string. Anchors, aliases and merge keys are refused: a rig file shows each value where it acts.
So are tags, which would be passed over, and nesting deeper than any file of ours.
"""

from __future__ import annotations

import math
import pathlib
import re
import shlex
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NoReturn

import yaml
from yaml.composer import Composer
from yaml.resolver import Resolver

from config.errors import ConfigError, Mend
from config.parsing.problems import Problem, config_error, problem_at

Path = tuple[str | int, ...]

_CORE_SCALARS = (
    ("null", re.compile(r"^(?:~|null|Null|NULL|)$"), "~nN"),
    ("bool", re.compile(r"^(?:true|True|TRUE|false|False|FALSE)$"), "tTfF"),
    ("int", re.compile(r"^(?:[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+)$"), "-+0123456789"),
    ("float", re.compile(r"^(?:[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.inf|\.nan)$"), "-+.0123456789"),
)


_SHIPPED = " ".join(shlex.quote(str(pathlib.Path(__file__).parents[1] / kind)) for kind in ("rigs", "maneuvers"))
_MOST_LEVELS = 60
_MOST_DIGITS = 300  # of a whole number; a float ends near 308


class _Core:
    """The scalar rules of the YAML 1.2 core schema, and no aliases; before PyYAML's composer among the bases of a loader."""

    _levels = 0
    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012  (PyYAML's own protocol: a class attribute)

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        event = self.peek_event()  # type: ignore[attr-defined]
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None):
            _refuse("anchors and aliases (& and *) are not used here; write the value out", event.start_mark)
        if getattr(event, "tag", None):
            _refuse("tags (!) are not used here; write the value alone", event.start_mark)
        if self._levels == _MOST_LEVELS:
            _refuse(f"nested deeper than {_MOST_LEVELS} levels", event.start_mark)
        self._levels += 1
        node: yaml.Node | None = super().compose_node(parent, index)  # type: ignore[misc]
        self._levels -= 1
        return node


def _refuse(what: str, mark: yaml.Mark) -> NoReturn:
    raise yaml.MarkedYAMLError(problem=what, problem_mark=mark)


for _kind, _pattern, _first in _CORE_SCALARS:
    for _letter in [*_first, ""] if _kind == "null" else _first:
        _Core.yaml_implicit_resolvers.setdefault(_letter, []).append((f"tag:yaml.org,2002:{_kind}", _pattern))


class _CoreLoader(_Core, yaml.SafeLoader):
    """PyYAML's own parser: it says best what is wrong and where."""


if yaml.__with_libyaml__:
    from yaml._yaml import CParser

    class _FastLoader(_Core, Composer, CParser, Resolver):
        """The same nodes by libyaml's parser, in an eighth of the time."""

        def __init__(self, text: str) -> None:
            CParser.__init__(self, text)
            Composer.__init__(self)
            Resolver.__init__(self)


_READ_DIFFERENTLY = "\t?\ufeff"  # by the two parsers; beside these they differ in a last line without an end


@lru_cache(maxsize=16)  # a rig is read for its schema, its devices and its units
def _root(text: str) -> yaml.Node | None:
    """The node tree, which nobody changes. What libyaml refuses is read again, for the message."""
    if yaml.__with_libyaml__ and text.endswith("\n") and not any(sign in text for sign in _READ_DIFFERENTLY):
        with suppress(yaml.YAMLError):
            return _FastLoader(text).get_single_node()
    return _CoreLoader(text).get_single_node()


@dataclass(slots=True)
class YamlTree:
    """A parsed file. `problems` holds what is wrong with the YAML itself though it could be read (duplicate keys, ...)."""

    name: str
    text: str
    root: yaml.Node
    problems: list[Problem] = field(default_factory=list)
    plain: Any = None

    def value(self, path: Sequence[str | int]) -> Any:
        """The plain value at `path`; None where there is none."""
        value = self.plain
        for part in path:
            try:
                value = value[part]
            except (KeyError, IndexError, TypeError):
                return None
        return value

    def mark(self, path: Sequence[str | int], *, of_key: bool = False) -> tuple[int, int]:
        """Line and column (from 1) of the value at `path`, or of its key; where it is missing, of the section's own key."""
        node, key = self.root, self.root
        for part in path:
            found = entry(node, part)
            if found is None:
                of_key = True
                break
            key, node = found
        mark = (key if of_key or _is_block(node) else node).start_mark
        return mark.line + 1, mark.column + 1

    def problem(
        self,
        path: Sequence[str | int],
        what: str,
        *,
        of_key: bool = False,
        value: str = "",
        limit: str = "",
        next_step: str = "",
        mend: Mend | None = None,
    ) -> Problem:
        """A problem placed at `path`."""
        place = self.mark(path, of_key=of_key)
        return problem_at(self.name, *place, what, value=value, limit=limit, next_step=next_step, mend=mend)


def parse(text: str, name: str) -> YamlTree:
    """Parse one YAML document whose top is a mapping; ConfigError with line and column when that is not possible."""
    try:
        root = _root(text)
    except yaml.MarkedYAMLError as error:
        raise _syntax_error(error, name) from error
    except yaml.reader.ReaderError as error:
        raise _character_error(error, text, name) from error
    if root is None:
        raise config_error(name, [problem_at(name, 1, 1, "the file is empty", next_step=f"Start from a shipped file: `ls {_SHIPPED}`.")])
    if not isinstance(root, yaml.MappingNode):
        raise config_error(
            name,
            [
                problem_at(
                    name, root.start_mark.line + 1, root.start_mark.column + 1, "the file must be a mapping of keys to values (key: value)"
                )
            ],
        )
    tree = YamlTree(name, text, root)
    tree.plain = _plain(tree, root, ())
    return tree


def dotted(path: Sequence[str | int]) -> str:
    """("plant", "effects", 2, "where") → "plant.effects[2].where"."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


def entry(node: yaml.Node, part: str | int) -> tuple[yaml.Node, yaml.Node] | None:
    """Key node and value node of one entry of a mapping or list; None where there is none."""
    if isinstance(node, yaml.MappingNode):
        return next(((key, value) for key, value in node.value if key.value == part), None)
    if isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value):
        return node.value[part], node.value[part]
    return None


def end_of(node: yaml.Node) -> int:
    """Where the value's own text ends; PyYAML's end of a block section lies after the blank lines and comments that follow it."""
    while isinstance(node, yaml.CollectionNode) and not node.flow_style:
        last = node.value[-1]
        node = last[1] if isinstance(last, tuple) else last
    return int(node.end_mark.index)


def _is_block(node: yaml.Node) -> bool:
    return isinstance(node, yaml.CollectionNode) and not node.flow_style


def _plain(tree: YamlTree, node: yaml.Node, path: Path) -> Any:
    if isinstance(node, yaml.MappingNode):
        return _plain_mapping(tree, node, path)
    if isinstance(node, yaml.SequenceNode):
        return [_plain(tree, item, (*path, index)) for index, item in enumerate(node.value)]
    return _scalar(node)


def _plain_mapping(tree: YamlTree, node: yaml.MappingNode, path: Path) -> dict[str, Any]:
    first_line: dict[str, int] = {}
    plain: dict[str, Any] = {}
    for key_node, value_node in node.value:
        key = key_node.value
        line, column = key_node.start_mark.line + 1, key_node.start_mark.column + 1
        if not isinstance(key, str):
            tree.problems.append(problem_at(tree.name, line, column, f"a key of {dotted(path) or 'the file'} is not a plain word"))
        elif key in first_line:
            what = f"{dotted((*path, key))} stands twice"
            tree.problems.append(
                problem_at(tree.name, line, column, what, value=f"first on line {first_line[key]}", next_step="Remove one.")
            )
        else:
            first_line[key] = line
            plain[key] = _plain(tree, value_node, (*path, key))
    return plain


def _scalar(node: yaml.Node) -> Any:
    text = node.value
    match node.tag.removeprefix("tag:yaml.org,2002:"):
        case "null":
            return None
        case "bool":
            return text.lower() == "true"
        case "int":
            return math.inf if len(text) > _MOST_DIGITS else int(text, 0) if text[:2] in ("0x", "0o") else int(text)
        case "float":
            return float(text.replace(".inf", "inf").replace(".nan", "nan"))
    return text


def _syntax_error(error: yaml.MarkedYAMLError, name: str) -> ConfigError:
    mark = error.problem_mark or error.context_mark
    line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    begun = error.context_mark.line + 1 if error.context_mark else line
    context = f" ({error.context})" if error.context else ""
    if begun != line and context.startswith(" (while scanning"):  # of a quote that is not closed, the end of the file says little
        context = f" ({error.context} begun on line {begun})"
    advice = "Indent with spaces: YAML takes no tabs." if r"'\t'" in str(error.problem) else ""
    return config_error(name, [problem_at(name, line, column, f"not readable as YAML: {error.problem}{context}", next_step=advice)])


def _character_error(error: yaml.reader.ReaderError, text: str, name: str) -> ConfigError:
    before = text[: error.position]
    line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
    return config_error(name, [problem_at(name, line, column, f"not readable as YAML: character {text[error.position]!r} is not allowed")])
