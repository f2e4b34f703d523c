"""The acceptance table and the page."""

from __future__ import annotations

import json

import pytest

from config.schema.rig import Rig
from daemon.cli.main import main
from tuning.paper import rows_cycles, rows_figures, rows_joint, rows_link, rows_motion
from tuning.paper.misprints import MISPRINTS
from tuning.paper.page import paper_page
from tuning.paper.row import RowMaker
from tuning.paper.table import MAKERS
from tuning.variants import with_link, with_valve

QUICK = (
    rows_joint.ratings,
    rows_joint.equation_1,
    rows_joint.loop_margins,
    rows_joint.equations_2_3,
    rows_figures.warm_up_run,
    rows_figures.unequal_cylinder,
    rows_link.frequencies,
    rows_link.ratio_of_frequencies,
    rows_link.energy,
    rows_link.newton_against_lagrange,
    rows_motion.straight_line,
    rows_motion.kinematics,
    rows_motion.equation_14,
    rows_cycles.books_rule,
)


@pytest.mark.parametrize("make", QUICK, ids=lambda make: make.__name__)
def test_row_holds(rig: Rig, make: RowMaker) -> None:
    row = make(rig)
    assert row.ok, row


def test_table_has_27_makers_and_misprints_name_rows_of_it() -> None:
    assert len(set(MAKERS)) == 27
    assert all(0 <= item.row <= 27 for item in MISPRINTS)


def test_a_wrong_plant_is_noticed(rig: Rig) -> None:
    """The table is computed, not typed in: another payload or valve must make rows fail."""
    assert not rows_joint.equation_4(with_valve(rig, "rotary", rated_flow_m3_per_s=1.2e-3)).ok
    assert not rows_motion.unfiltered(with_link(rig, payload_kg=15.0)).ok


@pytest.mark.slow
def test_every_row_holds(capsys: pytest.CaptureFixture[str]) -> None:
    """`longreach paper --json`: 27 rows in order, all hold, exit status 0."""
    status = main(["paper", "--json"])
    rows = json.loads(capsys.readouterr().out)
    assert [row["row"] for row in rows] == list(range(1, 28))
    assert [row["row"] for row in rows if not row["ok"]] == []
    assert status == 0
    assert {"row", "claim", "measured", "target", "tolerance", "ok"} <= rows[0].keys()


@pytest.mark.slow
def test_page_is_self_contained(rig: Rig) -> None:
    page = paper_page(rig, [make(rig) for make in QUICK])
    assert page.count("<img src='data:image/png;base64,") == 8
    assert "http" not in page
    assert page.count("<tr>") == 2 + len(QUICK) + len(MISPRINTS)
