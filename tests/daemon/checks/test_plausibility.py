"""Plausibility of measured positions: closed-form motions in, numbers and trips out; and no trip in what the rig ships."""

from __future__ import annotations

from math import exp, nan, pi, sqrt
from pathlib import Path
from random import Random
from typing import Any

import pytest

from config.errors import ConfigError
from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text
from config.schema.rig import Rig
from daemon.checks.checks import Check, Reaction
from daemon.checks.declared import plausibility
from daemon.checks.declared.plausibility import FLOW, NOISE, RATE, STUCK, PlausibilityWatch
from daemon.checks.interlocks import interlocks, rig_facts
from daemon.cycle.facts import Facts
from daemon.lockstep import LockstepRig
from daemon.modes.run_watch import RunVerdict
from servo_control.signals import Mode

LOADED = load_rig("ornl_testbed")
PERIOD_NS = 1_000_000


def plausibility_checks(rig: Rig, facts: Facts) -> list[Check]:
    """Those of the section `interlocks.plausibility`."""
    pages = {declaration.anchor for family in plausibility.FAMILIES for declaration in family.checks}
    return [check for check in interlocks(rig, facts) if check.page.partition("#")[2] in pages]


class Bench:
    """Feeds one rig's watch with invented samples of the rotary joint."""

    def __init__(self, rig: Rig = LOADED.rig, mode: Mode = Mode.RUNNING) -> None:
        self.facts = rig_facts(rig)
        self.values = self.facts.blank()
        self.watch = PlausibilityWatch(rig, self.facts)
        self.checks = {check.name: check for check in plausibility_checks(rig, self.facts)}
        self.now_ns = 0
        self.put("mode", float(mode))
        self.put("rotary.reference", 0.0)
        self.put("rotary.command_V", 0.0)

    def put(self, fact: str, value: float) -> None:
        self.values[self.facts.index(fact)] = value

    def value(self, fact: str) -> float:
        return self.values[self.facts.index(f"rotary.{fact}")]

    def sample(self, position: float, periods: int = 1, age_ns: int = 0) -> None:
        self.now_ns += periods * PERIOD_NS
        self.put("rotary.position", position)
        self.put("rotary.position_raw", position)
        self.put("rotary.position_age_s", age_ns * 1e-9)
        self.watch.update(self.values, self.now_ns, 0)

    def failed(self) -> list[str]:
        return [name for name, check in self.checks.items() if name.startswith("rotary") and not check.passes(self.values)]


def test_uniform_motion_has_its_rate_and_no_noise() -> None:
    bench = Bench()
    for number in range(100):
        bench.sample(0.5e-3 * number)
    assert bench.value(RATE) == pytest.approx(0.5)
    assert bench.value(NOISE) == pytest.approx(0.0, abs=1e-12)


def test_skipped_periods_are_not_a_jump() -> None:
    bench = Bench()
    for number in (0, 1, 2, 42, 43):
        bench.sample(1e-3 * number, periods=1 if number != 42 else 40)
    assert bench.value(RATE) == pytest.approx(1.0)
    assert bench.failed() == []


def test_a_jump_trips_in_the_cycle_in_which_it_comes() -> None:
    bench = Bench()
    for position in (0.0, 0.0, 0.02):
        bench.sample(position)
    assert bench.value(RATE) == pytest.approx(20.0)
    assert bench.failed()[0] == "rotary position rate", "the cause before its consequence"


def test_a_sample_that_was_missing_is_bridged_by_the_true_time() -> None:
    bench = Bench()
    bench.sample(0.0)
    bench.sample(nan)
    bench.sample(nan)
    bench.sample(3e-3)
    assert bench.value(RATE) == pytest.approx(1.0)


def test_a_sample_read_twice_is_no_news() -> None:
    bench = Bench()
    bench.sample(0.0)
    bench.sample(1e-3)
    bench.sample(1e-3, age_ns=PERIOD_NS)
    assert bench.value(RATE) == pytest.approx(1.0)


def test_white_noise_gives_its_expected_mean() -> None:
    """|second difference| of white noise of rms s has the mean s √6 √(2/π)."""
    bench, chance, rms, seen = Bench(), Random(1), 1e-4, []
    for _ in range(4000):
        bench.sample(chance.gauss(0.0, rms))
        seen.append(bench.value(NOISE))
    assert sum(seen[100:]) / len(seen[100:]) == pytest.approx(rms * sqrt(6.0) * sqrt(2.0 / pi), rel=0.05)


def test_stuck_counts_the_reference_only_while_the_servo_acts_and_the_count_stands() -> None:
    bench = Bench()
    bench.sample(0.0)
    for number in range(1, 16):
        bench.put("rotary.reference", 1e-3 * number)
        bench.sample(0.0)
    assert bench.value(STUCK) == pytest.approx(15e-3)
    assert bench.failed() == ["rotary position stuck"]
    bench.sample(1e-4)
    assert bench.value(STUCK) == 0.0
    bench.put("mode", float(Mode.DISARMED))
    bench.put("rotary.reference", 0.5)
    bench.sample(1e-4)
    assert bench.value(STUCK) == 0.0


def test_unexplained_motion_is_the_leaky_sum_of_what_the_command_should_have_moved() -> None:
    """A valve that does not answer: K V (1 − exp(−t/τ)) τ."""
    bench = Bench()
    rate_per_V = 1.0 / LOADED.rig.servo["rotary"].velocity_feedforward
    bench.sample(0.0)
    bench.put("rotary.command_V", 1.0)
    for _ in range(50):
        bench.sample(0.0)
    assert bench.value(FLOW) == pytest.approx(rate_per_V * 0.1 * (1.0 - 0.6065), rel=0.02)
    for _ in range(60):
        bench.sample(0.0)
    assert bench.failed() == ["rotary unexplained motion"]
    bench.put("mode", float(Mode.FAULT))
    bench.sample(0.0)
    assert bench.failed() == [], "a reset must be able to arm again"


def test_a_command_of_the_null_bias_moves_nothing() -> None:
    """The valve is shut at 0.2 V, so that 0 V is a motion that does not come: a leaky sum of -0.2 V times the rate per volt."""
    bias_V = 0.2
    rig = rig_from_text(apply_overrides(LOADED.text, [f"servo.rotary.null_bias={bias_V} V"]))
    still, shut = Bench(rig), Bench(rig)
    still.put("rotary.command_V", bias_V)
    cycles, keep = 40, exp(-0.001 / 0.1)
    for _ in range(cycles + 1):  # the first sample is compared with nothing
        still.sample(0.3)
        shut.sample(0.3)
    assert still.value(FLOW) == pytest.approx(0.0, abs=1e-15)
    rate = bias_V / rig.servo["rotary"].velocity_feedforward
    assert shut.value(FLOW) == pytest.approx(rate * 0.001 * (1.0 - keep**cycles) / (1.0 - keep))


@pytest.mark.parametrize(("periods", "counts"), [(50, True), (51, False)])
def test_a_command_older_than_50_ms_explains_nothing_and_accuses_of_nothing(periods: int, counts: bool) -> None:
    bench, volts = Bench(), 0.1
    bench.put("rotary.command_V", volts)
    bench.sample(0.3)
    bench.sample(0.3, periods)
    rate = volts / LOADED.rig.servo["rotary"].velocity_feedforward
    assert bench.value(FLOW) == (pytest.approx(rate * 0.05) if counts else 0.0)
    bench.sample(0.3)
    assert bench.value(FLOW) == pytest.approx(rate * 0.001 + (exp(-0.001 / 0.1) * rate * 0.05 if counts else 0.0)), "and it begins anew"


def test_reactions_are_those_of_the_rig_file_and_absent_limits_are_not_checked() -> None:
    changed = apply_overrides(LOADED.text, ["interlocks.plausibility.noise_reaction=controlled stop"])
    text = changed.replace("    flow: 0.5 ", "    rate: null\n    flow: null ")
    checks = Bench(rig_from_text(text)).checks
    assert set(checks) == {f"{joint} position {rule}" for joint in LOADED.rig.joints for rule in ("noise", "stuck")}
    assert checks["rotary position noise"].reaction is Reaction.STOP
    assert checks["rotary position stuck"].reaction is Reaction.FAULT
    with pytest.raises(ConfigError, match="noise_reaction"):
        rig_from_text(apply_overrides(LOADED.text, ["interlocks.plausibility.noise_reaction=shrug"]))


def test_reactions_are_ordered_by_severity() -> None:
    assert list(Reaction) == [Reaction.FAULT, Reaction.STOP_THEN_FAULT, Reaction.STOP, Reaction.REFUSE, Reaction.WARN]


def largest_shares(request: dict[str, Any], directory: Path, loaded: LoadedRig = LOADED) -> tuple[RunVerdict, str, float]:
    """Verdict, reason and the largest share of a plausibility limit in the whole run."""
    with LockstepRig(loaded, directory) as rig:
        rig.arm()
        rig.start(request)
        run, values = rig.loop.keeper.run, rig.loop.values
        limits = [(check.index, check.high) for check in plausibility_checks(rig.rig, rig.facts)]
        worst = 0.0
        while run.active:
            rig.loop.cycle()
            worst = max(worst, max(values[index] / high for index, high in limits))
        return run.verdict, run.reason, worst


@pytest.mark.slow
@pytest.mark.parametrize("shaper", [{"kind": "none"}, {"kind": "three_term", "focal": "mid"}, {"kind": "adaptive"}])
def test_the_demo_stays_far_from_the_limits(shaper: dict[str, Any], tmp_path: Path) -> None:
    verdict, reason, worst = largest_shares({"maneuver": {"name": "paper_line"}, "approach": True, "shaper": shaper}, tmp_path)
    assert verdict is RunVerdict.VALID, reason
    assert worst < 0.5


@pytest.mark.parametrize(
    "name", ["paper_line_y30", "fast_strokes", "jog", "hold", "joint_steps", "multisine", "slow_triangle", "staircase"]
)
@pytest.mark.slow
def test_shipped_maneuvers_stay_far_from_the_limits(name: str, tmp_path: Path) -> None:
    verdict, reason, worst = largest_shares({"maneuver": {"name": name}, "approach": True}, tmp_path)
    assert verdict is RunVerdict.VALID, reason
    assert worst < 0.5


@pytest.mark.slow
def test_the_sine_sweep_without_feedback_stops_for_the_tip_and_for_nothing_else(tmp_path: Path) -> None:
    """It excites the link's resonance on purpose, and the rig's limit of the tip acceleration ends that; not so with feedback."""
    sweep = {"maneuver": {"name": "sine_sweep"}, "approach": True}
    verdict, reason, worst = largest_shares(sweep, tmp_path)
    assert verdict is RunVerdict.VALID, reason
    assert worst < 0.5
    without = tmp_path / "without.yaml"
    without.write_text(apply_overrides(LOADED.text, ["end_point.gain=0"]))
    _, reason, worst = largest_shares(sweep, tmp_path, load_rig(without))
    assert "tip.acceleration" in reason
    assert worst < 0.5
