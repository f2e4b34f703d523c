"""Find, run the maneuver that would tell, find again, until a name is confirmed or nothing separates what is left.

The rig is whatever `run` runs: a design in, the path of its log out. A maneuver is run once to fit and as often as is proposed to decide:
what tells two explanations apart also says what the numbers of each are, and one fitted to logs that hardly showed it would lose for that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from config.errors import LongreachError, ManeuverError
from config.progress import Progress
from config.schema.rig import Rig
from gap.find import find
from gap.maneuvers.closed_loop import planned
from gap.maneuvers.designs import ManeuverDesign, designs
from gap.outcome.findings import explanations
from gap.settings import Settings

MOST_ROUNDS = 4
FIRST = ("paper_line", "joint_steps")  # what is run when there are no logs yet: one to fit, one to decide

Run = Callable[[ManeuverDesign, str], Path]


@dataclass(frozen=True, slots=True)
class Round:
    """One search: its number from 1, its findings, its logs, and the design it asked for (None: it asked for none)."""

    number: int
    content: dict[str, Any]
    logs: tuple[Path, ...]
    holdouts: tuple[Path, ...]
    asked: ManeuverDesign | None

    @property
    def names(self) -> list[str]:
        return [f"{item['effect']} at {item['where']}" for item in explanations(self.content)]

    @property
    def open_sets(self) -> list[list[str]]:
        """Every set of look-alikes."""
        return [
            [f"{x['effect']} at {x['where']}" for x in (item, *item["look_alikes"])]
            for item in explanations(self.content)
            if item["look_alikes"]
        ]

    @property
    def settled(self) -> bool:
        """Nothing is in doubt: no gap, wrong constants only, or names that are all confirmed."""
        if self.content["verdict"] in ("no_gap", "parameter_mismatch"):
            return True
        return bool(self.names) and all(item["confirmed"] for item in explanations(self.content))


@dataclass(slots=True)
class LoopCourse:
    """All rounds and how it ended: confirmed, needs_sensor, not_separable, not_runnable or rounds_used_up."""

    rounds: list[Round] = field(default_factory=list)
    outcome: str = ""
    why: str = ""

    def as_dict(self) -> dict[str, Any]:
        return {
            "outcome": self.outcome,
            "why": self.why,
            "rounds": [
                {
                    "round": one.number,
                    "verdict": one.content["verdict"],
                    "names": one.names,
                    "look_alikes": one.open_sets,
                    "holdout_after": one.content["gap"]["holdout_after"],
                    "logs": [str(path) for path in one.logs],
                    "holdouts": [str(path) for path in one.holdouts],
                    "next_maneuver": one.content["next_maneuver"],
                }
                for one in self.rounds
            ],
            "findings": self.rounds[-1].content if self.rounds else None,
        }


def resolve(
    rig: Path | str,
    logs: Sequence[Path],
    holdouts: Sequence[Path],
    out: Path,
    run: Run,
    progress: Progress,
    show: Callable[[Round], None],
    most_rounds: int = MOST_ROUNDS,
    settings: Settings | None = None,
) -> LoopCourse:
    """Rounds of search and run until settled. `show` gets every round as it ends; results go to `out`/round-N."""
    course, fitted, deciding = LoopCourse(), list(logs), list(holdouts)
    for number in range(1, most_rounds + 1):
        found = find(rig, fitted, deciding, out / f"round-{number}", progress, settings or Settings())
        asked = _asked(found.content)
        course.rounds.append(Round(number, found.content, tuple(fitted), tuple(deciding), asked))
        show(course.rounds[-1])
        if _ended(course, most_rounds) or asked is None:
            return course
        try:
            new = _logged(asked, f"round-{number}", found.content["next_maneuver"]["repeats"], run, progress)
            fitted, deciding = [*fitted, new[0]], [*deciding, *new[1:]]
        except LongreachError as refused:
            course.outcome, course.why = "not_runnable", f"{asked.label}: {refused}"
            return course
    return course


def _logged(design: ManeuverDesign, name: str, deciding: int, run: Run, progress: Progress) -> list[Path]:
    """One log to fit and those that decide. Where the rig stops the run, which no model had foreseen, with half the power again."""
    uses = ["fit", *(f"decide-{k}" for k in range(1, deciding + 1))]
    try:
        return [run(design, f"{name}-{use}") for use in uses]
    except LongreachError as refused:
        if design.smaller is None:
            raise
        progress(f"{design.label}: {refused}. Half the power.")
        return _logged(design.smaller, f"{name}-smaller", deciding, run, progress)


def first_designs(rig: Rig) -> tuple[ManeuverDesign, ManeuverDesign]:
    """Two different maneuvers this rig can run: the shipped ones where they fit, else forms made for its first joint.

    ManeuverError when the rig allows no two.
    """
    forms = designs(rig, [next(iter(rig.joints))], thorough=False)
    wanted = [*map(ManeuverDesign, FIRST), *(d for d in forms if d.name == "fast_strokes"), *(d for d in forms if d.name == "staircase")]
    possible = [design for design in wanted if _runs(rig, design)]
    names = list(dict.fromkeys(design.name for design in possible))
    if len(names) < 2:
        raise ManeuverError("no two shipped maneuvers fit this rig", value=", ".join(names), next_step="Give --log and --holdout.")
    first, second = (next(design for design in possible if design.name == name) for name in names[:2])
    return first, second


def _runs(rig: Rig, design: ManeuverDesign) -> bool:
    try:
        planned(rig, design.content)
    except LongreachError:
        return False
    return True


def _asked(content: dict[str, Any]) -> ManeuverDesign | None:
    """The maneuver to run next, if running one would help."""
    proposal = content["next_maneuver"]
    if not proposal or proposal["sensor"] or not proposal["repeats"]:
        return None
    return ManeuverDesign(proposal["name"], proposal["parameters"])


def _ended(course: LoopCourse, most_rounds: int) -> bool:
    """Sets the outcome when the last round is the end."""
    last = course.rounds[-1]
    proposal = last.content["next_maneuver"]
    if last.settled:
        course.outcome, course.why = "confirmed", last.content["why"]
    elif not proposal:
        course.outcome, course.why = "not_separable", f"no maneuver is proposed: {last.content['why']}"
    elif last.asked is None:
        course.outcome, course.why = "needs_sensor" if proposal["sensor"] else "not_separable", proposal["why"]
    elif last.number == most_rounds:
        course.outcome, course.why = "rounds_used_up", f"after {most_rounds} rounds: {last.content['why']}"
    return bool(course.outcome)
