"""Hold vibration and spectra, against signals of known amplitude."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.errors import LogError
from recording.evaluation.spectrum import hann_spectrum, without_gaps
from recording.evaluation.vibration import decaying_sine, decibels, hold_vibration, rms_mps2
from recording.files.reader import read_log
from recording.importing.ingest import ingest
from tests.support.recording import session

RING = {0: 2.8, 2: 2.7, 4: 3.6}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("vibration")
    unshaped = session.recorded_run(folder / "none.mcap", ring_mps2=RING)
    shaped = session.recorded_run(folder / "zvd.mcap", shaper="zvd", ring_mps2={index: 0.1 * value for index, value in RING.items()})
    return unshaped, shaped


@pytest.mark.slow
def test_the_amplitudes_put_in_come_out(runs: tuple[Path, Path]) -> None:
    holds = hold_vibration(read_log(runs[0]))
    assert [hold.move for hold in holds] == ["move 1", "move 2", "move 3"]
    assert [hold.amplitude_mps2 for hold in holds] == pytest.approx([2.8, 2.7, 3.6], rel=1e-3)
    assert [hold.end_t_s for hold in holds] == pytest.approx([3.21, 11.31, 16.41])
    # Rayleigh, cantilever with a tip mass: 3 EI / (L^3 (M + 33/140 m L)) at 50 in and 40 in with 45 lb
    assert [hold.frequency_Hz for hold in holds] == pytest.approx([2.4963, 2.4963, 3.5013], rel=1e-3)


def test_the_approach_is_no_move_of_the_program(tmp_path: Path) -> None:
    recording = session.Session(tmp_path / "a.mcap", ring_mps2={0: 9.0, 2: 2.8})
    recording.position = [0.1, 40 * 0.0254]
    plan = recording.plan("paper_line", 1, approach=True)
    assert plan.segments[0].name == "approach"
    recording.cycles(session.Mode.HOLDING, 10)
    recording.start(plan)
    recording.until(session.Mode.RUNNING, lambda outputs: outputs.segment == 5, plan)
    holds = hold_vibration(read_log(recording.close()))
    assert [(hold.move, round(hold.amplitude_mps2, 3)) for hold in holds] == [("move 1", 2.8)]


def test_decibels_relative_to_the_unshaped_run(runs: tuple[Path, Path]) -> None:
    unshaped, shaped = (hold_vibration(read_log(path)) for path in runs)
    assert decibels(shaped, unshaped) == pytest.approx([-20.0] * 3, abs=0.01)
    assert rms_mps2(unshaped) == pytest.approx(np.sqrt((2.8**2 + 2.7**2 + 3.6**2) / 3), rel=1e-3)


@pytest.mark.parametrize("true_Hz", [2.2, 2.5, 2.8])
@pytest.mark.parametrize("damping", [0.0, 0.005, 0.05])
def test_fit_finds_amplitude_when_the_frequency_is_believed_wrong(true_Hz: float, damping: float) -> None:
    t = np.arange(-0.6, 0.6, 1e-3)
    noise = np.random.default_rng(3).normal(0.0, 0.02, len(t))
    omega = 2 * np.pi * true_Hz
    values = 0.4 + 1.7 * np.exp(-damping * omega * t) * np.cos(omega * t + 1.1) + noise
    amplitude, frequency = decaying_sine(t, values, 2.5, damping)
    assert amplitude == pytest.approx(1.7, rel=0.01)
    assert frequency == pytest.approx(true_Hz, rel=0.01)


def test_a_quiet_hold_reads_as_noise_not_as_zero() -> None:
    t = np.arange(-0.6, 0.6, 1e-3)
    amplitude, _ = decaying_sine(t, np.random.default_rng(4).normal(0.0, 0.05, len(t)), 2.5, 0.005)
    assert 0.0 < amplitude < 0.02  # sigma 0.05 over 1200 samples: about 0.05 sqrt(2 / 600)


def test_logs_without_tip_or_link_are_refused(tmp_path: Path) -> None:
    (tmp_path / "d.csv").write_text("t_s,axis.position\n0,1\n1,2\n")
    ingest(tmp_path / "d.csv", None, tmp_path / "a.mcap")
    with pytest.raises(LogError, match="the log has no rig file inside"):
        hold_vibration(read_log(tmp_path / "a.mcap"))


def test_a_maneuver_without_holds_is_refused(tmp_path: Path) -> None:
    recording = session.Session(tmp_path / "a.mcap")
    recording.cycles(session.Mode.HOLDING, 100)
    with pytest.raises(LogError, match=r"the log has no hold after a move\. A move must be followed by a hold of more than 1"):
        hold_vibration(read_log(recording.close()))


def test_spectrum_shows_the_amplitude_of_a_sine() -> None:
    t = np.arange(0.0, 20.0, 1e-3)
    frequency, amplitude = hann_spectrum(5.0 + 2.0 * np.sin(2 * np.pi * 3.0 * t) + 0.1 * np.sin(2 * np.pi * 11.0 * t), 1e-3)
    assert amplitude[np.argmin(np.abs(frequency - 3.0))] == pytest.approx(2.0, rel=1e-3)
    assert amplitude[np.argmin(np.abs(frequency - 11.0))] == pytest.approx(0.1, rel=1e-3)
    assert amplitude[0] < 0.01  # the mean is out


def test_lost_samples_are_bridged() -> None:
    assert list(without_gaps(np.array([0.0, np.nan, 2.0, np.nan]))) == [0.0, 1.0, 2.0, 2.0]
