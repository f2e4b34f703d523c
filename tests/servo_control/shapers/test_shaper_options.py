"""Which options each kind of command filter has: those that change what it does, and no others."""

from __future__ import annotations

from typing import Any

import pytest

from config.errors import ManeuverError
from config.schema.rig import Rig
from servo_control.planning.planning import plan_run
from servo_control.shapers.shaper_choice import KINDS, OPTIONS, ShaperChoice, refuse_idle_options, with_kind
from servo_control.shapers.shaper_setup import Extensions, set_up_shaper
from tests.support.servo_control.testbed_runs import request

OTHER: dict[str, Any] = {
    "focal": "initial",
    "frequency_Hz": 3.0,
    "damping_ratio": 0.1,
    "delay_s": 0.12,
    "vibration": 0.1,
    "frequency_scale": 1.1,
    "frequency_range": 0.1,
}


def _followed(rig: Rig, content: dict[str, Any]) -> list[tuple[float, ...]]:
    """Reference over half a second in which both joints move."""
    setup = set_up_shaper(rig, ShaperChoice.from_content(content), Extensions(0.9, 1.1, 0.9, 1.1))
    shaper = setup.build()
    shaper.reset([0.0, 0.9])
    reference, rate, found = [0.0, 0.9], [0.0, 0.0], []
    for cycle in range(1, 500):
        shaper.step([0.0004 * cycle, 0.9 + 0.0004 * cycle], [0.4, 0.4], reference, rate)
        found.append(tuple(reference))
    return found


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "zero_delay"])  # which corrects the moves beforehand
def test_the_options_of_a_kind_are_those_that_change_it(rig: Rig, kind: str) -> None:
    usual = _followed(rig, {"kind": kind})
    changing = {key for key, value in OTHER.items() if _followed(rig, {"kind": kind, key: value}) != usual}
    assert changing == set(OPTIONS[kind])


def test_an_idle_option_is_refused_with_those_that_the_kind_has() -> None:
    with pytest.raises(ManeuverError, match=r"zvd does not use delay_s: 0\.07 .limit: joints, focal, frequency_Hz") as refused:
        refuse_idle_options({"kind": "zvd", "delay_s": 0.07})
    assert refused.value.refusal.mend == {"--delay": None}
    with pytest.raises(ManeuverError, match="adaptive does not use frequency_Hz and damping_ratio"):
        refuse_idle_options({"kind": "adaptive", "frequency_Hz": 4.2, "damping_ratio": 0.01, "joints": ["rotary"]})


@pytest.mark.parametrize("content", [{"kind": "adaptive", "focal": "mid", "delay_s": None}, {"kind": "zv", "frequency_Hz": 2.1}, {}])
def test_what_is_used_or_says_nothing_is_taken(content: dict[str, Any]) -> None:
    refuse_idle_options(content)


def test_a_run_that_was_logged_with_an_idle_option_is_planned_as_it_was(rig: Rig, paper_y30: dict[str, Any]) -> None:
    idle, plain = (plan_run(rig, request(paper_y30, shaper={"kind": "adaptive", **more})) for more in ({"frequency_Hz": 4.2}, {}))
    assert idle.summary() == plain.summary()


def test_another_kind_takes_over_what_it_has() -> None:
    content = {"kind": "three_term", "delay_s": 0.1, "focal": "final", "joints": ["rotary"]}
    assert with_kind(content, "adaptive_coefficients") == {"kind": "adaptive_coefficients", "delay_s": 0.1, "joints": ["rotary"]}
    assert with_kind(content, "none") == {"kind": "none", "joints": ["rotary"]}
