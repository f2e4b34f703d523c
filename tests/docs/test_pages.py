"""Every page: links that lead somewhere, lines and lengths as promised, commands that exist; and docstrings that cite pages that exist."""

from __future__ import annotations

import argparse
import contextlib
import io
import re
import shlex
from pathlib import Path

import pytest

from daemon.cli.command_line import build_parser
from tests.docs.pages import (
    CHECKOUT,
    DOCS,
    GUIDE,
    PAGES,
    Block,
    anchors,
    blocks,
    inline_commands,
    is_generated,
    links,
    name,
    prose,
    shown_commands,
)

LONGEST_LINE = 110
MOST_WORDS = 1200
OLD_SOURCES = re.compile(r"\b(?:physics|design|evidence|anchors|testing|rooms)\.md\b|(?<![/\w])gap\.md")
ROOMS = "benchmarks|config|daemon|drivers|gap|longreach|recording|servo_control|sim_backend|tests|tuning"
CODE_PATH = re.compile(rf"`((?:{ROOMS})/[\w/]+\.py)`")
CODE = [path for path in CHECKOUT.rglob("*.py") if not {".venv", "build"} & set(path.relative_to(CHECKOUT).parts)]


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_and_anchors_resolve(page: Path) -> None:
    wrong = []
    for number, target in links(page):
        path, _, anchor = target.partition("#")
        leads_to = (page.parent / path).resolve() if path else page
        if not leads_to.exists() or (anchor and anchor not in anchors(leads_to)):
            wrong.append(f"{name(page)}:{number}: {target}")
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("page", [page for page in PAGES if not is_generated(page) and page.parent.name != "results"], ids=name)
def test_lines_fit_beside_a_terminal(page: Path) -> None:
    long = [f"{name(page)}:{number}: {len(line)}" for number, line in prose(page) if len(line) > LONGEST_LINE]
    assert not long, "\n".join(long)


@pytest.mark.parametrize("page", [page for page in PAGES if page != DOCS / "roadmap.md"], ids=name)
def test_files_named_in_pages_exist(page: Path) -> None:
    """All but the roadmap, which names what is yet to be made."""
    missing = [path for path in CODE_PATH.findall(page.read_text()) if not (CHECKOUT / path).exists() and "NAME" not in path]
    assert not missing


@pytest.mark.parametrize("page", GUIDE, ids=name)
def test_guide_pages_are_short(page: Path) -> None:
    assert len(page.read_text().split()) <= MOST_WORDS


@pytest.mark.parametrize("page", [page for page in PAGES if page.parent.name == "method" or page in GUIDE[1:]], ids=name)
def test_pages_do_not_cite_what_the_repository_does_not_hold(page: Path) -> None:
    found = [
        f"{name(page)}:{number}" for number, line in enumerate(page.read_text().splitlines(), 1) if OLD_SOURCES.search(_no_links(line))
    ]
    assert not found, found


def _no_links(line: str) -> str:
    return re.sub(r"\]\([^)]*\)", "]", line).replace("docs/method/gap.md", "")


def test_every_page_is_listed() -> None:
    """Whatever stands in docs is reached from docs/README.md, directly or from a page that is."""
    reached: set[Path] = set()
    waiting = [DOCS / "README.md"]
    while waiting:
        page = waiting.pop()
        if page in reached:
            continue
        reached.add(page)
        targets = ((page.parent / target.partition("#")[0]).resolve() for _, target in links(page))
        waiting += [target for target in targets if target.suffix == ".md" and target.is_file()]
    listed = reached | {DOCS / "roadmap.md"} | set((DOCS / "decisions").rglob("*.md"))
    assert sorted(name(page) for page in DOCS.rglob("*.md") if page not in listed) == []


SHOWN = [block for page in PAGES for block in blocks(page) if block.words[:1] in (("sh",), ("console",))]
COMMANDS = [(str(block), command) for block in SHOWN for command in shown_commands(block)]


@pytest.mark.parametrize(("where", "command"), COMMANDS, ids=[f"{where} {command}" for where, command in COMMANDS])
def test_commands_in_blocks_parse(where: str, command: str) -> None:
    words = [word for word in shlex.split(command) if word != "&"]
    assert _usage_error(words[1:]) == "", f"{where}: {command}"


@pytest.mark.parametrize("page", GUIDE, ids=name)
def test_commands_named_in_prose_exist(page: Path) -> None:
    wrong = []
    for number, command in inline_commands(page):
        error = _usage_error(shlex.split(command)[1:])
        if error and "arguments are required" not in error and "expected" not in error:
            wrong.append(f"{name(page)}:{number}: {command}: {error}")
    assert not wrong, "\n".join(wrong)


def _usage_error(words: list[str]) -> str:
    """What the real parser says against a command line; nothing for a right one."""
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        try:
            build_parser().parse_args(words)
        except SystemExit as end:
            return " ".join(said.getvalue().splitlines()[-2:]) if end.code else ""
        except argparse.ArgumentError as error:
            return str(error)
    return ""


def test_blocks_say_what_they_are() -> None:
    """A fenced block names its language, so that commands are found."""
    bare: list[Block] = [block for page in GUIDE for block in blocks(page) if not block.words]
    assert [str(block) for block in bare] == []


def test_code_cites_pages_that_exist() -> None:
    """docs/….md and #anchors in docstrings, comments and messages."""
    wrong = []
    for path in CODE:
        for cited in re.findall(r"docs/[\w./-]+\.(?:md|html)(?:#[\w-]+)?", path.read_text()):
            page, _, anchor = cited.partition("#")
            if not (CHECKOUT / page).exists() or (anchor and anchor not in anchors(CHECKOUT / page)):
                wrong.append(f"{path.relative_to(CHECKOUT)}: {cited}")
    assert not wrong, "\n".join(wrong)
