"""One case from sealed answer to findings: logs are made and forgotten, the finder gets files only. One task of an executor."""

from __future__ import annotations

import hashlib
import json
import re
import subprocess
import tempfile
import time
import traceback
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import gap
import sim_backend
from config.errors import LongreachError
from config.loading.load import load_rig
from config.whole_file import replaced_when_done
from gap.data.log_parts import load_parts
from gap.find import search_gap
from gap.settings import Settings
from tests.blind.baselines import baselines
from tests.blind.cases import RIG, Case
from tests.blind.shipped_maneuver import record_shipped
from tests.blind.truth.session import record

BESIDE = ("maneuvers", "loop.py", "report/report.py")  # of gap/, left out of the version
SECOND_TAKE = 4  # after those of a proposed maneuver
CHAMBER = "resolution: 0.7 psi, noise: 7.5 psi, bandwidth: 500 Hz, low: 0 psi, high: 3000 psi"


@dataclass(frozen=True, slots=True)
class Work:
    """What a worker gets: the case as text and the file for its result."""

    case: str
    result: str
    threads: int = 1
    commit: str = ""


def finder_digest() -> str:
    """First digits of a hash over the sources of the search and of its kernel: which version gave a result.

    What has no part in what a search names is left out: what chooses and runs the next maneuver, and the page.
    """
    folders = [Path(module.__file__).parent for module in (gap, sim_backend) if module.__file__]
    sources = sorted((folder, path.relative_to(folder)) for folder in folders for path in folder.rglob("*.py"))
    naming = [folder / name for folder, name in sources if not any(name.is_relative_to(part) for part in BESIDE)]
    return hashlib.sha256(b"".join(path.read_bytes() for path in naming)).hexdigest()[:10]


def commit() -> str:
    """Commit of the checkout the search is from, or an empty string outside of one."""
    where = Path(next(iter(gap.__path__)))
    done = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, cwd=where, check=False)
    return done.stdout.strip()


_DIGEST = finder_digest()  # of what this process has imported


def run_case(work: Work) -> dict[str, Any]:
    """Make the logs, search, ask the baselines; write the result file and return its content."""
    case = Case.from_json(work.case)
    with tempfile.TemporaryDirectory(prefix="blind-") as name:
        folder = Path(name)
        settings = Settings(workers=work.threads, propose=case.group == "look_alike")
        result = _searched(case, folder, settings) | {"commit": work.commit}
    path = Path(work.result)
    with replaced_when_done(path) as part:
        part.write_text(json.dumps(result, indent=1) + "\n")
    return result


def rig_text(case: Case) -> str:
    """The rig file that the finder gets: without the hidden effects, with chamber pressures where they are logged."""
    text = load_rig(RIG).text
    for effect, where in case.removed:
        text = re.sub(rf"^\s*- \{{effect: {effect}, where: {where},.*\n", "", text, count=1, flags=re.MULTILINE)
    if case.setting.chambers:
        names = [f"{joint}.pressure_{side}" for joint in ("rotary", "prismatic") for side in "ab"]
        lines = "".join(f"    {name}: {{{CHAMBER}}}\n" for name in names)
        text = text.replace("    tip.acceleration: {resolution", lines + "    tip.acceleration: {resolution", 1)
    return text


def _searched(case: Case, folder: Path, settings: Settings) -> dict[str, Any]:
    rig = load_rig(RIG).rig
    (folder / "rig.yaml").write_text(rig_text(case))
    fit, holdout = folder / "fit.csv", folder / "holdout.csv"
    for take, (path, (kinds, duration_s)) in enumerate(((fit, case.fit), (holdout, case.holdout))):
        record(rig, case.setting, kinds, duration_s, take, path)
    fits = [fit]
    if case.second_fit:
        fits.append(folder / "second_fit.csv")
        record(rig, case.setting, *case.second_fit, SECOND_TAKE, fits[-1])
    start, processor = time.monotonic(), time.process_time()
    result = search_files(folder / "rig.yaml", fits, [holdout], settings)
    result |= {"seconds": round(time.monotonic() - start, 1), "finder": _DIGEST, "date": f"{datetime.now(UTC):%Y-%m-%d %H:%M}"}
    result["processor_s"] = round(time.process_time() - processor, 1)
    result["baselines"] = baselines(folder / "rig.yaml", fit, holdout, result)
    result["resolved"] = _second_round(case, folder, result, settings)
    return {"name": case.name} | result


def search_files(rig: Path, logs: list[Path], holdouts: list[Path], settings: Settings) -> dict[str, Any]:
    """The findings of a search on files; no report is written, nobody reads one a case."""
    try:
        loaded = load_rig(rig)
        fitted, held = (load_parts(paths, loaded.rig) for paths in (logs, holdouts))
        content = search_gap(loaded, fitted, held, lambda line: None, settings).content
    except LongreachError as refused:
        return {"verdict": "refused", "why": str(refused), "findings": [], "gap": None}
    except Exception:  # a study counts a crash of the search as what it is and goes on
        return {"verdict": "crashed", "why": traceback.format_exc()[-2000:], "findings": [], "gap": None}
    kept = {key: content[key] for key in ("verdict", "why", "findings", "leads", "gap", "next_maneuver", "data")}
    kept["where"] = content["where"][:2]
    kept["alarms"] = [key for key, item in content["parameters"].items() if item["alarm"]]
    text = json.dumps(kept, default=float)
    return json.loads(text.replace(f"{rig.parent}/", ""))  # the folder is gone tomorrow


def _second_round(case: Case, folder: Path, result: dict[str, Any], settings: Settings) -> dict[str, Any] | None:
    """For look-alikes with a proposed maneuver: run it twice on the hidden machine and search again with both runs added."""
    proposal = result.get("next_maneuver")
    if result["verdict"] != "ambiguous" or not proposal or not proposal.get("repeats"):
        return None
    more = [folder / "more_fit.csv", folder / "more_holdout.csv"]
    for take, path in enumerate(more, 2):
        record_shipped(load_rig(RIG).rig, replace(case.setting), proposal["name"], take, path)
    again = search_files(folder / "rig.yaml", [folder / "fit.csv", more[0]], [folder / "holdout.csv", more[1]], settings)
    return {"maneuver": proposal["name"], **{key: again[key] for key in ("verdict", "why", "findings", "leads", "gap") if key in again}}
