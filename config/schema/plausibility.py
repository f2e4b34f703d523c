"""The `interlocks.plausibility` section: what a measured position cannot do, in shares of what the joint's own limits say.

One set of numbers fits every joint: rates count in `rate_limit`s of the joint, distances in `following_error_limit`s.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from config.schema.section import Section, quantity

ReactionWord = Literal["fault", "controlled stop, then fault", "controlled stop"]  # most severe first


class Plausibility(Section):
    """Checks that a measured position is one that the joint can have. An absent limit is not checked."""

    rate: float | None = quantity("", "position changes faster than this many rate limits: a jump", 4.0, low=1.5, high=1000)
    rate_reaction: ReactionWord = Field(default="fault", description="what a jump does while armed")
    noise: float | None = quantity(
        "", "mean deviation from uniform motion from one sample to the next, in following error limits", 0.01, low=1e-4, high=1
    )
    noise_reaction: ReactionWord = Field(default="fault", description="what noise does while armed")
    stuck: float | None = quantity(
        "", "the reference is this many following error limits from where the count last changed", 0.1, low=1e-3, high=1
    )
    stuck_reaction: ReactionWord = Field(default="fault", description="what a stuck position does while armed")
    flow: float | None = quantity(
        "",
        "motion that the command of the last 0.1 s does not explain, in following error limits; takes 1 / velocity_feedforward for "
        "the rate per volt, so it is for valves that command a flow",
        None,
        low=0.05,
        high=10,
    )
    flow_reaction: ReactionWord = Field(default="fault", description="what motion against the command does while armed")
    apart: float | None = quantity(
        "",
        "the joint's two position sensors differ by this many following error limits; takes the signal JOINT.second_position, and counts "
        "the motion between samples of unlike age",
        None,
        low=1e-3,
        high=10,
    )
    apart_reaction: ReactionWord = Field(default="fault", description="what position sensors that disagree do while armed")
