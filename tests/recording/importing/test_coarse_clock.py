"""Stamps that a coarse clock has doubled: the true times come back within a tick where that is certain, else the table is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from config.errors import LogError
from recording.files.reader import read_log
from recording.importing.coarse_clock import regular_period, spread
from recording.importing.ingest import ingest, ingest_parts
from recording.importing.table import Floats


def floored(t_s: Floats, tick_s: float) -> Floats:
    return np.floor(t_s / tick_s + 1e-9) * tick_s


def numbered(t_s: Floats) -> dict[str, Floats]:
    return {"t_s": t_s, "axis.position": np.arange(len(t_s), dtype=float)}


def written(t_s: Floats, folder: Path) -> Path:
    data = folder / "data.csv"
    data.write_text("t_s,axis.position\n" + "".join(f"{t:.6g},{k}\n" for k, t in enumerate(t_s)))
    return data


@pytest.mark.parametrize(
    ("period_s", "tick_s"), [(5e-3, 10e-3), (3.7e-3, 10e-3), (0.25e-3, 1e-3), (0.9e-3, 1e-3), (1e-3 / 3, 1e-3), (1e-3, 15.625e-3)]
)
@pytest.mark.parametrize("phase", [0.0, 0.3, 0.77])
@pytest.mark.parametrize("start_s", [0.0, 1_700_000_000.0])
def test_a_regular_period_comes_back_from_any_tick(period_s: float, tick_s: float, phase: float, start_s: float) -> None:
    rows = 2000
    true = period_s * (np.arange(rows) + phase)
    stamps = start_s + floored(true, tick_s)
    found, said = spread(numbered(stamps))
    assert len(said) == 1
    assert np.all(np.diff(found) > 0)
    assert (found[-1] - found[0]) / (rows - 1) == pytest.approx(period_s, abs=tick_s / rows)
    assert np.max(np.abs((found - start_s) - true)) <= 1.1 * tick_s
    assert found[0] == stamps[0]


def test_a_table_with_three_decimals_is_imported_and_the_warning_has_the_numbers(tmp_path: Path) -> None:
    true = 0.4e-3 * np.arange(1000)
    data = written(np.round(true, 3), tmp_path)
    report = ingest(data, None, tmp_path / "a.mcap")
    np.testing.assert_allclose(read_log(tmp_path / "a.mcap").columns["t_s"], true, atol=1e-5)
    assert report.rate_Hz == pytest.approx(2500, rel=1e-4)
    (said,) = report.warnings
    assert said == (
        "The clock is coarse (0 to 0.4 s): 599 of 1000 rows have the stamp of the row before, in steps of 1 ms."
        " They round one period of 0.4 ms (± 0.001 ms), onto which the rows are spread, by 0.4 ms at most."
    )


def test_a_clock_that_is_itself_written_in_whole_milliseconds(tmp_path: Path) -> None:
    """15.625 ms, as 15 or 16."""
    true = 5e-3 * np.arange(1500)
    ingest(written(np.floor(1e3 * floored(true, 15.625e-3)) / 1e3, tmp_path), None, tmp_path / "a.mcap")
    np.testing.assert_allclose(read_log(tmp_path / "a.mcap").columns["t_s"], true, atol=16e-3)


def test_each_piece_between_pauses_by_itself_and_empty_cells_keep_their_place(tmp_path: Path) -> None:
    """Rows without a stamp or a position are left out, and those behind them stand where they were measured."""
    one = 5e-3 * np.arange(600)
    true = np.concatenate([one, 7.003 + one])
    lines = [f"{t:.2f},{k}" for k, t in enumerate(floored(true, 10e-3))]
    lines[100], lines[200] = f",{100}", lines[200].split(",")[0] + ","
    (tmp_path / "data.csv").write_text("t_s,axis.position\n" + "\n".join(lines) + "\n")
    reports = ingest_parts(tmp_path / "data.csv", None, tmp_path / "a.mcap")
    assert [report.rows for report in reports] == [598, 600]
    first, second = (read_log(tmp_path / f"a-{number}.mcap").columns for number in (1, 2))
    np.testing.assert_allclose(first["t_s"], 5e-3 * first["axis.position"], atol=10e-3)
    np.testing.assert_allclose(np.diff(second["t_s"]), 5e-3, rtol=1e-2)
    assert [round(float(row)) for row in first["axis.position"][98:102]] == [98, 99, 101, 102]


def test_a_span_has_the_period_of_the_whole_table(tmp_path: Path) -> None:
    """Alone these 20 rows would say too little."""
    data = written(floored(5e-3 * np.arange(2000), 10e-3), tmp_path)
    (report,) = ingest_parts(data, None, tmp_path / "a.mcap", spans=[(4.0, 4.1)])
    np.testing.assert_allclose(np.diff(read_log(tmp_path / "a.mcap").columns["t_s"]), 5e-3, rtol=1e-3)
    assert report.warnings[0].startswith("The clock is coarse")


def test_a_span_beside_a_loss_has_a_period_of_its_own(tmp_path: Path) -> None:
    """What the refusal of the whole table advises."""
    stamps = with_rows(COARSE, lost=tuple(range(500, 520)))
    data = written(stamps, tmp_path)
    with pytest.raises(LogError, match="no regular period is certain"):
        ingest(data, None, tmp_path / "a.mcap")
    for number, (first, last) in enumerate([(0.0, 2.4), (2.7, 5.0)]):
        (report,) = ingest_parts(data, None, tmp_path / f"{number}.mcap", spans=[(first, last)])
        columns = read_log(tmp_path / f"{number}.mcap").columns
        np.testing.assert_allclose(np.diff(columns["t_s"]), 5e-3, rtol=1e-2)
        assert columns["t_s"][[0, -1]] == pytest.approx([first, last], abs=10e-3)
        assert report.warnings[0].startswith("The clock is coarse")


def with_rows(t_s: Floats, twice: tuple[int, ...] = (), lost: tuple[int, ...] = ()) -> Floats:
    counts = np.ones(len(t_s), dtype=int)
    counts[list(twice)], counts[list(lost)] = 2, 0
    return np.repeat(t_s, counts)


FINE, COARSE = 5e-3 * np.arange(1000), floored(5e-3 * np.arange(1000), 10e-3)
UNEVEN = floored(np.cumsum(np.random.default_rng(7).uniform(1e-3, 9e-3, 1000)), 10e-3)


@pytest.mark.parametrize(
    "stamps",
    [
        with_rows(FINE, twice=(400,)),
        with_rows(FINE, twice=(200, 500, 800)),
        with_rows(FINE, twice=tuple(range(500, 520))),
        with_rows(COARSE, twice=(300, 301, 302, 303)),
        with_rows(COARSE, lost=(300, 301, 302, 303)),
        np.concatenate([COARSE, COARSE[-1] + 0.5 + COARSE]),
        COARSE[:60],
        UNEVEN,
        np.zeros(300),
        np.array([0.0, 0.0]),
    ],
    ids=["one double row", "three, evenly", "twenty", "doubled", "lost", "gap", "short", "uneven", "one stamp", "two rows"],
)
def test_what_is_not_certain_is_refused_with_the_next_command(stamps: Floats, tmp_path: Path) -> None:
    data = written(stamps, tmp_path)
    with pytest.raises(
        LogError, match=r"time does not increase: .*\d+ rows have the stamp of the row before, and no regular period"
    ) as caught:
        ingest(data, None, tmp_path / "a.mcap")
    assert caught.value.refusal.next_step.endswith("take the part before or behind it (--from, --to).")
    assert [path.name for path in tmp_path.iterdir()] == ["data.csv"]
    part = caught.value.refusal.mend.get("--to")
    assert (part is not None) == (np.flatnonzero(np.diff(stamps) <= 0)[0] > 1)
    if part is not None:
        assert ingest_parts(data, None, tmp_path / "a.mcap", None, [(-math.inf, float(part))])[0].rows >= 2


def test_rows_that_were_copied_are_no_samples(tmp_path: Path) -> None:
    """Each row of a regular log twice, numbers and all; its stamps alone would be those of a clock twice as coarse as the samples."""
    data = tmp_path / "data.csv"
    data.write_text("t_s,axis.position\n" + "".join(2 * f"{t:.3f},{math.sin(t):.9f}\n" for t in FINE))
    with pytest.raises(LogError, match="1000 rows have the stamp of the row before"):
        ingest(data, None, tmp_path / "a.mcap")


def test_stamps_without_doubles_stay_as_they_are() -> None:
    """Also those of an uneven clock, and before and behind a clock that was set back."""
    for stamps in (FINE, np.sort(np.random.default_rng(3).uniform(0, 5, 500)), np.array([0.0, 1.0, 0.5, math.nan, 0.7])):
        found, said = spread(numbered(stamps))
        assert np.array_equal(found, stamps, equal_nan=True)
        assert said == ()


def test_chance_does_not_look_regular() -> None:
    """A few rows written twice by accident, in a thousand regular logs."""
    chance = np.random.default_rng(11)
    for _ in range(1000):
        stamps = with_rows(FINE[:500], twice=tuple(chance.integers(1, 499, chance.integers(1, 20))))
        assert regular_period(stamps, np.arange(len(stamps))) is None
