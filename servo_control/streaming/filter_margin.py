"""How much faster than its input the output of an adaptive filter can be, so that a hand-driven target leaves it room.

The output at t repeats the input of s, stretched in time by σ = ω(t)/ω(s), s being the phase c π earlier:

    ẏ = Σ A_i σ_i u̇,    ÿ = Σ A_i (σ_i² ü + σ̇_i u̇),    |σ̇| ≤ |ω̇(t)|/ω(s) + σ² |ω̇(s)|/ω(s),    |ω̇| ≤ |ω'(L)| L̇

Nobody knows what will be asked for, so the worst is taken: an extension that is drawn in at full rate while the filter waits.
A fixed filter adds weighted parts of the past, with positive weights of sum 1: its output is never faster than its input.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

from servo_control.link.link_mode import LinkFrequency
from servo_control.path.joint_limits import JointLimits
from servo_control.shapers import impulses
from servo_control.shapers.shaper_setup import ShaperSetup

PLACES = 200  # extensions that are tried
STEPS = 100  # of the way back from one of them
SMALL_M = 1e-4
SHARE = 0.5  # of a joint's acceleration that the stretching alone may take


def input_limits(setup: ShaperSetup, joints: Sequence[JointLimits]) -> tuple[list[float], list[float]]:
    """Rates and accelerations that the target of every joint may have, so that its reference stays within the joint's."""
    rates, accelerations = [joint.rate for joint in joints], [joint.acceleration for joint in joints]
    if setup.link is None:
        return rates, accelerations
    stretch, square, bend = _worst(setup, setup.link, joints[setup.extension].rate)
    for j in setup.joints:
        rates[j] = min(rates[j] / stretch, SHARE * accelerations[j] / bend)
        accelerations[j] = (accelerations[j] - bend * rates[j]) / square
    return rates, accelerations


def _worst(setup: ShaperSetup, link: LinkFrequency, rate: float) -> tuple[float, float, float]:
    """The largest Σ A σ, Σ A σ² and Σ A |σ̇| over the travel."""
    low, high = setup.travel
    weights = (impulses.zvd if setup.kind == "adaptive" else impulses.zv)(1.0, setup.damping_ratio)[0]
    found = [_sums(link, weights, low + (high - low) * n / PLACES, high, rate) for n in range(PLACES + 1)]
    stretch, square, bend = (max(column) for column in zip(*found, strict=True))
    return stretch, square, bend


def _sums(link: LinkFrequency, weights: Sequence[float], here: float, longest: float, rate: float) -> tuple[float, float, float]:
    omega, steep = link.omega_d(here), rate * _slope(link, here)
    stretch = square = weights[0]
    bend = 0.0
    for half_cycles, weight in enumerate(weights[1:], start=1):
        there = _earlier(link, here, longest, rate, half_cycles * pi)
        before = link.omega_d(there)
        sigma = omega / before
        stretch += weight * sigma
        square += weight * sigma**2
        bend += weight * (steep / before + sigma**2 * rate * _slope(link, there) / before)
    return stretch, square, bend


def _earlier(link: LinkFrequency, here: float, longest: float, rate: float, phase: float) -> float:
    """The extension before the link went through `phase` while it was drawn in."""
    step_s = phase / link.omega_d(longest) / STEPS
    there, left = here, phase
    for _ in range(STEPS):
        left -= link.omega_d(there) * step_s
        if left <= 0.0:
            break
        there = min(longest, there + rate * step_s)
    return there


def _slope(link: LinkFrequency, extension: float) -> float:
    """|dω/dL|."""
    return abs(link.omega_d(extension + SMALL_M) - link.omega_d(extension - SMALL_M)) / (2.0 * SMALL_M)
