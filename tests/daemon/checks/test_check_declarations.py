"""A check is declared once: a new file of one check is in the loop, in `why` and in the reference; and every check has its anchor there."""

from __future__ import annotations

import asyncio
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from config.loading.load import load_rig
from config.loading.shipped import shipped
from config.schema.rig import Rig
from daemon import checks_reference
from daemon.checks import declared
from daemon.checks.checks import Check, Reaction
from daemon.checks.interlocks import families, interlocks, proof_checks, rest_checks, rig_facts
from servo_control.signals import Mode
from tests.support.daemon.lockstep_requests import LockstepRequests, at_once
from tests.support.daemon.rigs import JOG, simple_rig, texts_of

CHECKOUT = Path(__file__).parents[3]
PAGE_NAME = "docs/reference/checks.md"
PAGE = CHECKOUT / PAGE_NAME
RIG_KEYS = (CHECKOUT / "docs" / "reference" / "rig.md").read_text()
RIGS = sorted(shipped("rigs"))

# A check nobody ships: with a fact of its own, and what computes it.
NEW_FILE = """
from math import inf

from daemon.checks.checks import Check, Reaction
from daemon.checks.declaration import Declaration, DeclaredFact, Family, Stage, joint_subject

LIMIT = 0.01


class Speed:
    def __init__(self, rig, facts):
        self._indices = [(facts.index(f"{joint}.velocity"), facts.index(f"{joint}.speed")) for joint in rig.joints]

    def update(self, values, now_ns, unix_ns):
        for velocity, speed in self._indices:
            values[speed] = max(values[speed], abs(values[velocity]))


SPEED = Declaration(
    name="{joint} crawl",
    fact="{joint}.speed",
    meaning="largest size of the estimated rate so far",
    unit="{unit}/s",
    limits=lambda rig, subject: (-inf, LIMIT),
    limit_from="at most 0.01",
    source="{source}",
    reaction=Reaction.REACTION,
    advice="Slower, then `longreach start`.",
)
FAMILIES = (
    Family(
        "Crawl", Stage.MOTION, lambda rig: [joint_subject(rig, joint) for joint in rig.joints], (SPEED,),
        facts=(DeclaredFact("{joint}.speed", 0.0),), watch=Speed,
    ),
)
"""


@pytest.fixture(params=["STOP", "FAULT", "STOP_THEN_FAULT"])
def new_check(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Reaction]:
    folder = tmp_path / "declared"
    folder.mkdir()
    (folder / "crawl.py").write_text(NEW_FILE.replace("Reaction.REACTION", f"Reaction.{request.param}"))
    monkeypatch.setattr(declared, "__path__", [*declared.__path__, str(folder)])
    monkeypatch.setattr(asyncio, "sleep", at_once)
    yield Reaction[request.param]
    sys.modules.pop("daemon.checks.declared.crawl", None)


def test_one_new_file_is_in_the_loop_in_why_and_in_the_reference(new_check: Reaction, tmp_path: Path) -> None:
    ends = {Reaction.FAULT: Mode.FAULT, Reaction.STOP: Mode.HOLDING, Reaction.STOP_THEN_FAULT: Mode.FAULT}
    with simple_rig(tmp_path / "logs") as (rig, _):
        rig.arm()
        why = asyncio.run(LockstepRequests(rig).handlers.checks({}))["checks"]
        (row,) = [row for row in why if row["name"] == "rotary crawl"]
        assert (row["ok"], row["limit"], row["unit"], row["source"]) == (True, "≤ 0.01", "rad/s", "plant.rotary.position")
        assert (row["reaction"], row["next_step"], row["page"]) == (
            new_check,
            "Slower, then `longreach start`.",
            f"{PAGE_NAME}#joint-crawl",
        )
        rig.start(JOG)
        rig.until(lambda: not rig.loop.keeper.run.active, 6.0)
        rig.cycles(2)  # "then fault" comes in the cycle after the arm is at rest
        assert rig.mode is ends[new_check]
        assert "rotary crawl" in rig.loop.keeper.run.reason
        if new_check is not Reaction.FAULT:
            assert any("running → stopping: rotary crawl" in text for text in texts_of(rig, "mode"))
    page = checks_reference.page()
    assert "### JOINT crawl\n" in page
    assert "Slower, then `longreach start`." in page


def test_the_page_is_what_the_declarations_say() -> None:
    assert PAGE.read_text() == checks_reference.page(), "run `make docs`"


@pytest.mark.parametrize("name", RIGS)
def test_every_check_of_every_shipped_rig_has_its_anchor_on_the_page(name: str) -> None:
    headings = re.findall(r"^#+ (.+)$", PAGE.read_text(), re.MULTILINE)
    anchors = {"".join(c for c in heading.lower().replace(" ", "-") if c.isalnum() or c in "-_") for heading in headings}
    rig = load_rig(name).rig
    for check in all_checks(rig):
        page, _, anchor = check.page.partition("#")
        assert (CHECKOUT / page) == PAGE
        assert anchor in anchors, check.name


def test_titles_are_told_apart() -> None:
    titles = [declaration.title for family in families() for declaration in family.checks]
    assert len(set(titles)) == len(titles)


def test_every_advice_ends_with_something_to_type() -> None:
    for family in families():
        for declaration in family.checks:
            assert re.search(r"`(longreach|systemctl|--settle)", declaration.advice), declaration.title


def test_every_key_of_the_rig_file_that_a_limit_or_reaction_comes_from_exists() -> None:
    """Against the page that is generated from the schema."""
    sources = [text for family in families() for d in family.checks for text in (d.limit_from, d.reaction_from, d.meaning)]
    keys = {key for text in sources for key in re.findall(r"`([a-z]+\.[\w.]+)`", text)}
    assert len(keys) > 15
    for key in keys:
        section, _, last = key.rpartition(".")
        part = re.search(rf"^## `{re.escape(section)}`.*?(?=^## )", RIG_KEYS, re.MULTILINE | re.DOTALL)
        assert part, key
        assert f"| `{last}` |" in part[0], key


def test_the_table_of_reactions_says_what_the_loop_does() -> None:
    """By hand, from the rules of docs/method/safety.md."""
    page = PAGE.read_text()
    assert "| controlled stop, then fault | refused | disarmed | fault | stopping → holding → fault | holding → fault | refused |" in page
    assert "| fault | refused | fault | fault | fault | fault | refused |" in page
    assert "| refuses arming | refused | disarmed | goes on | goes on | holding | goes on |" in page


def all_checks(rig: Rig) -> list[Check]:
    facts = rig_facts(rig)
    return [*interlocks(rig, facts), *proof_checks(rig, facts), *rest_checks(rig, facts)]
