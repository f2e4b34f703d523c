"""An unknown payload from one ordinary move on the whole rig, with the joint's stiffness taken from a move with 45 lb."""

from __future__ import annotations

import numpy as np
import pytest

from config.errors import LogError
from config.rig import Rig
from tuning.line_run import LineRun, coupled_run, plan_line
from tuning.payload import Hold, clamped_Hz, free_vibration, holds_of, joint_stiffness, payload
from tuning.variants import with_link

POUND = 0.45359237


def _run(rig: Rig, payload_kg: float) -> LineRun:
    changed = with_link(rig, payload_kg=payload_kg)
    return coupled_run(changed, plan_line(changed, "paper_line"))


def _measured(run: LineRun) -> np.ndarray:
    """What an accelerometer gives: 2 mg counts and noise, 5 mg bias."""
    noise = 0.02 * np.random.default_rng(1).standard_normal(len(run.tip_acceleration))
    return np.round((run.tip_acceleration + 0.05 + noise) / 0.0196) * 0.0196


def test_clamped_frequencies_of_the_beam_equation(rig: Rig) -> None:
    """9.006, 3.145, 1.892 and 1.478 Hz at 60 in, 0.1 %."""
    assert rig.link_mode is not None
    found = [clamped_Hz(rig.link_mode, pounds * POUND, 60 * 0.0254) for pounds in (0, 15, 45, 75)]
    assert found == pytest.approx([9.006, 3.145, 1.892, 1.478], rel=1e-3)


def test_free_vibration_of_a_made_up_signal() -> None:
    t = 0.001 * np.arange(1850)
    hold = free_vibration(0.3 + 2.0 * np.exp(-0.01 * 20 * t) * np.sin(20 * t + 1.0), 0.001, 1.0)
    assert (2 * np.pi * hold.frequency_Hz, hold.amplitude_mps2) == pytest.approx((20.0, 2.0), rel=0.002)


def test_silence_is_refused(rig: Rig) -> None:
    assert rig.link_mode is not None
    with pytest.raises(LogError, match="without command filter"):
        payload(rig.link_mode, 3e5, [Hold(1.0, 3.0, 0.001)])


@pytest.mark.parametrize("pounds", [10, 25, 60, 75])
def test_unknown_payload_within_3_percent(rig: Rig, pounds: float) -> None:
    """The rig file goes on believing 45 lb."""
    assert rig.link_mode is not None
    known = _run(rig, 45 * POUND)
    stiffness = joint_stiffness(rig.link_mode, 45 * POUND, holds_of(known, _measured(known)))
    run = _run(rig, pounds * POUND)
    assert payload(rig.link_mode, stiffness, holds_of(run, _measured(run))) == pytest.approx(pounds * POUND, rel=0.03)


def test_no_payload_is_no_payload(rig: Rig) -> None:
    assert rig.link_mode is not None
    run = _run(rig, 0.0)
    assert payload(rig.link_mode, 3.2e5, holds_of(run, _measured(run))) == pytest.approx(0.0, abs=0.05)
