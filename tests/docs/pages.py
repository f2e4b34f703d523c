"""Pages of README and docs taken apart: prose lines, fenced blocks, links, anchors, commands."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

CHECKOUT = Path(__file__).parents[2]
DOCS = CHECKOUT / "docs"
PAGES = [CHECKOUT / "README.md", CHECKOUT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]
GUIDE = [CHECKOUT / "README.md", *sorted((DOCS / "guide").rglob("*.md"))]
GENERATED = {"rig.md", "plant.md", "import_map.md", "calibration.md", "maneuver.md", "checks.md", "drivers.md"}
COMMAND = re.compile(r"longreach(?: |$)[^#\n]*")


@dataclass(frozen=True)
class Block:
    """A fenced block: its language and further words of the info string, and the lines between the fences."""

    page: Path
    line: int
    words: tuple[str, ...]
    lines: tuple[str, ...]

    def __str__(self) -> str:
        return f"{name(self.page)}:{self.line}"


def name(page: Path) -> str:
    return page.relative_to(CHECKOUT).as_posix()


def is_generated(page: Path) -> bool:
    """Written by a program: reference pages from the schema, results from measurements."""
    return page.parent.name == "reference" and page.name in GENERATED


def blocks(page: Path) -> Iterator[Block]:
    lines = page.read_text().splitlines()
    start = None
    for number, line in enumerate(lines):
        if not line.lstrip().startswith("```"):
            continue
        if start is None:
            start = number
        else:
            indent = len(lines[start]) - len(lines[start].lstrip())
            words = tuple(lines[start].strip().removeprefix("```").split())
            yield Block(page, start + 1, words, tuple(text[indent:] for text in lines[start + 1 : number]))
            start = None
    assert start is None, f"{name(page)}:{start + 1 if start is not None else 0}: a fence is not closed"


def prose(page: Path) -> Iterator[tuple[int, str]]:
    """Number and text of every line that is neither code nor a table nor a picture alone."""
    fenced = False
    for number, line in enumerate(page.read_text().splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced and not line.startswith(("|", "    ", "![")):
            yield number, line


def links(page: Path) -> Iterator[tuple[int, str]]:
    """Number of the line and target of every link that stays in the checkout."""
    fenced = False
    for number, line in enumerate(page.read_text().splitlines(), 1):
        fenced ^= line.lstrip().startswith("```")
        if fenced:
            continue
        for target in re.findall(r"\]\(([^)\s]+)\)", line):
            if "://" not in target:
                yield number, target


def anchors(page: Path) -> set[str]:
    """Anchors of a page's headings, as GitHub makes them."""
    found: set[str] = set()
    for _, line in prose(page):
        if match := re.match(r"#{1,6} (.*)", line):
            text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", match[1]).strip().lower()
            anchor = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
            number = sum(known == anchor or re.fullmatch(rf"{re.escape(anchor)}-\d+", known) is not None for known in found)
            found.add(f"{anchor}-{number}" if number else anchor)
    return found | set(re.findall(r'<a (?:id|name)="([^"]+)"', page.read_text()))


def shown_commands(block: Block) -> Iterator[str]:
    """Every `longreach …` of a block of commands, its continued lines joined, comments taken off."""
    text = re.sub(r"\\\n\s*", "", "\n".join(block.lines))
    console = block.words[:1] == ("console",)
    for line in text.splitlines():
        if console and not line.startswith("$ "):
            continue
        for part in re.split(r"&&|;|\|\|| \| ", line.removeprefix("$ ")):
            if match := COMMAND.match(part.partition(" > ")[0].strip().removeprefix("sudo ")):
                yield match[0].strip().rstrip("&").strip()


def inline_commands(page: Path) -> Iterator[tuple[int, str]]:
    """Commands named in prose, between back-ticks."""
    for number, line in enumerate(page.read_text().splitlines(), 1):
        for text in re.findall(r"`(longreach [^`]*)`", line):
            yield number, text
