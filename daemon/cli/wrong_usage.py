"""What a user reads when the words of a command do not fit its options: what was wrong, the nearest that there is, what to type next."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Sequence
from typing import NamedTuple

from config.parsing.nearest import nearest

_CHOICE = re.compile(r"argument (?P<of>[^:]+): invalid choice: '(?P<given>[^']*)' \(choose from (?P<known>.*)\)")
_UNKNOWN = re.compile(r"unrecognized arguments: (?P<given>.*)", re.DOTALL)
_MISSING = re.compile(r"the following arguments are required: (?:COMMAND|VERB)$")
_VALUE = re.compile(r"argument (?P<of>[^:]+): '(?P<given>[^']*)' is .*: nearest is (?P<near>.+)$")
_NAMES = re.compile(r"[\w-]+")


class WrongUsage(NamedTuple):
    """`of`: the command and verb that were named; `typed`: the next command. `with_usage`: the line of all options helps."""

    of: str
    said: str
    typed: str
    with_usage: bool = False


def wrong_usage(parser: argparse.ArgumentParser, words: Sequence[str], message: str) -> WrongUsage:
    """Of argparse's `message` on the `words` after the parser's own name."""
    if choice := _CHOICE.search(message):
        return _no_such_choice(parser, words, choice)
    if unknown := _UNKNOWN.search(message):
        return _no_such_option(parser, words, unknown["given"])
    if value := _VALUE.search(message):
        return WrongUsage(parser.prog, message, _with_value(parser, words, value))
    return WrongUsage(parser.prog, message, f"{parser.prog} --help", with_usage=not _MISSING.search(message))


def _no_such_choice(parser: argparse.ArgumentParser, words: Sequence[str], choice: re.Match[str]) -> WrongUsage:
    given, known = choice["given"], _NAMES.findall(choice["known"])
    near = nearest(given, known)
    if choice["of"] in ("COMMAND", "VERB"):
        said = f"there is no command {given!r}" + (f": nearest is {near!r}" if near else "")
        return WrongUsage(parser.prog, said, f"{parser.prog} {near} --help" if near else f"{parser.prog} --help")
    said = f"{choice['of']} cannot be {given!r}" + (f": nearest is {near!r}" if near else "") + f". One of: {', '.join(known)}."
    return WrongUsage(parser.prog, said, _with(parser, words, given, near) if near else f"{parser.prog} --help")


def _no_such_option(parser: argparse.ArgumentParser, words: Sequence[str], rest: str) -> WrongUsage:
    command = _named_command(parser, words)
    help_typed = f"{command.prog} --help"
    given = next((word for word in words if word.partition("=")[0] in rest.split() or word in rest.split()), rest)
    option = given.partition("=")[0]
    if not option.startswith("-"):
        return WrongUsage(command.prog, f"{rest!r} is one word too many", help_typed)
    if option in command._option_string_actions:
        behind = [*(word for word in words if word != given), given]
        return WrongUsage(command.prog, f"{option} stands behind the command", _typed(parser, behind))
    known = [name for name in command._option_string_actions if name.startswith("--")]
    near = nearest(option, known, alike=0.8)  # all of them begin alike
    said = f"there is no option {option}" + (f": nearest is {near}" if near else "")
    return WrongUsage(command.prog, said, _with(parser, words, option, near) if near else help_typed)


def _named_command(parser: argparse.ArgumentParser, words: Sequence[str]) -> argparse.ArgumentParser:
    """The parser of the command, and of its verb, that the words name."""
    for word in words:
        verbs = next((action for action in parser._actions if isinstance(action, argparse._SubParsersAction)), None)
        if verbs is None:
            break
        parser = verbs.choices.get(word, parser)
    return parser


def _with_value(parser: argparse.ArgumentParser, words: Sequence[str], wrong: re.Match[str]) -> str:
    """The same command with the nearest value after the option, or beside its "="; its help where the value stands among others."""
    options, given, near = wrong["of"].split("/"), wrong["given"], wrong["near"]
    for place, word in enumerate(words):
        option, equals, value = word.partition("=")
        if option not in options:
            continue
        if equals and value == given:
            return _typed(parser, [*words[:place], f"{option}={near}", *words[place + 1 :]])
        if given in words[place + 1 :]:
            at = words.index(given, place + 1)
            return _typed(parser, [*words[:at], near, *words[at + 1 :]])
    return f"{parser.prog} --help"


def _typed(parser: argparse.ArgumentParser, words: Sequence[str]) -> str:
    return f"{parser.prog} {shlex.join(words)}"


def _with(parser: argparse.ArgumentParser, words: Sequence[str], given: str, better: str) -> str:
    """The same command with `better` in the place of `given`, alone or beside its "="."""
    mended = []
    for word in words:
        option, equals, value = word.partition("=")
        if word == given or (equals and option == given):
            mended.append(better + equals + value)
        else:
            mended.append(f"{option}={better}" if equals and value == given else word)
    return _typed(parser, mended)
