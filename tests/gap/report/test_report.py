"""The proof: a report that stands alone, findings that keep the contract, a rig file that the daemon runs with."""

from __future__ import annotations

import base64
import datetime
import difflib
import json
import re
import struct
from html import escape
from pathlib import Path
from typing import Any

import pytest

from config.checking.check import check_rig
from config.errors import LogError
from config.loading.load import LoadedRig, load_rig, rig_from_text
from daemon.lockstep import run_lockstep
from gap.find import find
from gap.maneuvers.designs import ManeuverDesign
from gap.report.picture import write_picture
from gap.settings import Settings
from tests.support.gap import axis_logs
from tests.support.gap.findings_schema import problems

pytestmark = pytest.mark.slow
TITLES = (
    "Gap, step by step", "Logs never used", "Fingerprint: coulomb_friction at axis", "Closed-loop replay",
    "Spectrum", "Constants", "Not seen", "Improved rig file", "Inputs",
)  # fmt: skip
QUIET = Settings(propose=False)
AT = {"start": {"axis": "0.125 m"}, "joint": "axis"}
DESIGNS = {
    "fit": ManeuverDesign("staircase", AT | {"step": "10 mm", "steps": 3, "hold": "0.5 s"}),
    "holdout": ManeuverDesign("slow_triangle", AT | {"amplitude": "0.05 m", "rate": "0.1 m/s", "cycles": 2}),
    "unused": ManeuverDesign("slow_triangle", AT | {"amplitude": "0.03 m", "rate": "0.03 m/s", "cycles": 1}),
}


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of one search on logs of the daemon; the model lacks Coulomb friction."""
    folder = tmp_path_factory.mktemp("report")
    text = axis_logs.axis_text()
    truth = LoadedRig(rig_from_text(text), text, "axis.yaml")
    logs = {use: run_lockstep(truth, [design.request], folder / use, seed=k)[0] for k, (use, design) in enumerate(DESIGNS.items())}
    (folder / "axis.yaml").write_text(axis_logs.axis_text("coulomb_friction"))
    found = find(folder / "axis.yaml", [logs["fit"]], [logs["holdout"]], folder, lambda line: None, QUIET, [logs["unused"]])
    write_picture(found, folder / "picture.png", "axis")
    with pytest.raises(LogError, match="was used by the search"):
        find(folder / "axis.yaml", [logs["fit"]], [logs["holdout"]], folder / "x", lambda line: None, QUIET, [logs["fit"]])
    return folder


@pytest.fixture(scope="module")
def content(out: Path) -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads((out / "findings.json").read_text())
    return loaded


def test_findings_keep_the_contract(content: dict[str, Any]) -> None:
    assert problems(content) == []
    assert content["findings"][0]["effect"] == "coulomb_friction"


def test_the_schema_notices_what_is_wrong(content: dict[str, Any]) -> None:
    spoiled = json.loads(json.dumps(content))
    spoiled["verdict"] = "maybe"
    spoiled["inputs"][0]["sha256"] = "1234"
    del spoiled["findings"][0]["t"]
    spoiled["gap"]["holdout_after"] = None
    assert len(problems(spoiled)) == 4


def test_the_report_needs_nothing_else(out: Path) -> None:
    page = (out / "report.html").read_text()
    assert not re.search(r"(src|href)=\"(?!data:image/png;base64,)", page)
    assert "http" not in page
    assert not re.search(r"<(script|link|iframe)", page)
    for title in TITLES:
        assert title in page, title
    assert page.count("data:image/png;base64,") == 5


def test_the_first_screen_has_the_verdict_the_names_the_numbers_and_the_picture(out: Path, content: dict[str, Any]) -> None:
    """All in one section ahead of everything else, no taller than a screen."""
    page = (out / "report.html").read_text()
    first = page[page.index('<section class="first">') : page.index("</section>")]
    assert page.index('<section class="first">') < page.index("<h2>")
    (image,) = re.findall(r"data:image/png;base64,([^\"]+)", first)
    height_px = struct.unpack(">II", base64.b64decode(image)[16:24])[1]
    rows, words = first.count("<tr>"), re.sub(r"<[^>]+>", " ", first)
    assert escape(content["why"].split(",")[0]) in words
    friction = content["findings"][0]["parameters"]["friction"]
    low, high = (f"{end:.4g}" for end in friction["ci95"])
    assert f"friction {friction['value']:.4g} N ({low} to {high})" in words
    assert f"{content['gap']['holdout_after']:.4g} noise floors" in words
    lines = len(words) / 100 + 2 * first.count("<p")  # of some 100 characters and 22 px, with their distances
    assert height_px + 30 * rows + 22 * lines < 800


def test_the_gap_shrinks_on_the_log_never_used(content: dict[str, Any]) -> None:
    fresh = content["unused_logs"][0]
    assert fresh["before"] > 10
    assert fresh["after"] < 1.3
    assert fresh["before_ci95"][0] < fresh["before"] < fresh["before_ci95"][1]


def test_the_closed_loop_replay_comes_nearer_to_the_measurement(out: Path) -> None:
    """Command and tracking error, simulated from the reference alone."""
    cell = r"<td>([\d.e-]+)"
    row = re.search(rf"<tr><td>axis</td>{cell}</td>{cell}</td>{cell} m</td>{cell} m</td></tr>", (out / "report.html").read_text())
    assert row
    before_V, after_V, before_m, after_m = map(float, row.groups())
    assert after_V < 0.3 * before_V
    assert after_m < 0.5 * before_m


def test_the_improved_file_is_a_readable_diff_and_passes_the_check(out: Path) -> None:
    old, new = (out / "axis.yaml").read_text().splitlines(), (out / "rig.yaml").read_text().splitlines()
    changed = [line for line in difflib.unified_diff(old, new, lineterm="", n=0) if line[:1] in "+-" and line[:3] not in ("+++", "---")]
    added = [line for line in changed if line.startswith("+")]
    entry = re.compile(r"\+ +- \{effect: coulomb_friction, where: axis, friction: [\d.]+ N\}  # \[gap\] longreach gap find")
    assert any(entry.match(line) for line in added)
    assert all("[gap]" in line for line in added)
    assert len(changed) <= 10
    assert not [f.text for f in check_rig(load_rig(out / "rig.yaml"), datetime.date(2026, 1, 1)) if f.level == "error"]


def test_the_daemon_runs_with_the_improved_file(out: Path, tmp_path: Path) -> None:
    log = run_lockstep(load_rig(out / "rig.yaml"), [DESIGNS["unused"].request], tmp_path)[0]
    assert log.exists()


def test_the_picture_is_a_png(out: Path) -> None:
    assert (out / "picture.png").read_bytes().startswith(b"\x89PNG")
