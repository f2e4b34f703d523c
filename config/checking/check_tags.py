"""The provenance tags of the plant section: which numbers are held fixed, and what looks like a tag and is none."""

from __future__ import annotations

from collections.abc import Iterator

from config.checking.finding import Finding
from config.parsing.nearest import nearest_text
from config.parsing.provenance import TAGS, bracketed, fixed_numbers
from config.parsing.yaml_tree import YamlTree, dotted
from config.schema.rig import Rig

_WORDS = tuple(tag for tag in TAGS if len(tag) > 1)  # single letters in brackets are units too


def check_tags(_: Rig, tree: YamlTree) -> Iterator[Finding]:
    """Findings about tags; a file without [fixed] and without slips has none."""
    held = fixed_numbers(tree)
    if held:
        yield Finding("ok", f"held fixed for `longreach gap find`: {', '.join(map(dotted, held))}")
    for number, line in enumerate(tree.text.splitlines(), start=1):
        for word in bracketed(line):
            if word not in TAGS and len(word) > 1 and (near := nearest_text(word, _WORDS)):
                text = f"{tree.name}:{number}:{line.index('#') + 1}: [{word}] is no tag of where a number comes from{near}; it is not used"
                yield Finding("warning", text)
