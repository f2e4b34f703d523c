"""What the pages call by example names (my_rig.yaml, LOG.mcap, day1.csv …), as small as it can be: made when a command first names it."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text
from daemon.lockstep import LockstepRig, run_lockstep
from daemon.modes.mode_machine import OperatorAction
from servo_control.signals import Mode
from tests.docs.pages import CHECKOUT, DOCS, blocks
from tests.support.gap import axis_logs

MOVES = "[6 in, -6 in]"
TABLE_S = 20.5  # the pages cut pieces up to 20 s out of it


class World:
    """Makes things in `folder`, once, and copies those that a command names to where it runs."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def lay_out(self, directory: Path, page: str, text: str) -> None:
        """Into `directory` what `text` names, as `page` means it."""
        (directory / "config").symlink_to(CHECKOUT / "config")
        for name in THINGS | OF_PAGES.get(page, {}):
            if re.search(rf"(?<![\w/.-]){re.escape(name)}(?![.-]?\w)", text) or (name.endswith("/") and f" {name}" in text):
                made, copy = self.thing(name, page), directory / name
                copy.parent.mkdir(parents=True, exist_ok=True)
                if made.is_dir():
                    shutil.copytree(made, copy, dirs_exist_ok=True)
                else:
                    shutil.copy(made, copy)

    def thing(self, name: str, page: str = "") -> Path:
        own = OF_PAGES.get(page, {})
        path = self.folder / (f"of-{page}" if name in own else "") / name
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            (own | {k: v for k, v in THINGS.items() if k not in own})[name](self, path)
        return path

    def run(self, command: str) -> None:
        """A command line in the world's own folder."""
        subprocess.run(["bash", "-c", command], cwd=self.folder, env=environment(), check=True, capture_output=True, timeout=250)


def environment(**others: str) -> dict[str, str]:
    """`longreach` and `python` are this checkout's."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return {**os.environ, "PATH": path, "PYTHONPATH": str(CHECKOUT), **others}


def my_rig(*changes: str) -> LoadedRig:
    """The shipped rig under another name."""
    text = apply_overrides(load_rig("ornl_testbed").text, ["name=my_rig", *changes])
    return LoadedRig(rig_from_text(text), text, "my_rig.yaml")


def _rig_file(world: World, path: Path) -> None:
    path.write_text(my_rig().text)


def _request(shaper: str, y0: str = "40 in") -> dict[str, object]:
    parameters = [f"y0={y0}", f"moves={MOVES}", "hold=1.5 s"]
    return {"maneuver": {"name": "paper_line"}, "parameters": parameters, "shaper": {"kind": shaper}, "approach": True}


def _faulty_log(world: World, path: Path) -> None:
    """Three runs, then an e-stop: there is something to report, to diagnose and to replay."""
    scratch = path.with_suffix(".made")
    with LockstepRig(my_rig(), scratch) as rig:
        rig.arm()
        for _ in range(3):
            rig.start(_request("adaptive"))
            run = rig.loop.keeper.run
            rig.until(lambda run=run: not run.active, 60.0)  # type: ignore[misc]
        rig.post(OperatorAction.ESTOP)
        rig.until(lambda: rig.mode is Mode.FAULT)
        rig.cycles(2500)
    max(scratch.glob("*.mcap"), key=lambda made: made.stat().st_size).rename(path)


def _run_log(world: World, path: Path, seed: int, temperature: str = "40 degC") -> None:
    rig = my_rig(f"plant.oil.initial_temperature={temperature}")
    (made,) = run_lockstep(rig, [_request("none")], path.with_suffix(".made"), seed)
    made.rename(path)


def _copy(of: str) -> Callable[[World, Path], None]:
    return lambda world, path: shutil.copy(world.thing(of), path)  # type: ignore[return-value]


def _shipped(rig: str, *without: str) -> Callable[[World, Path], None]:
    lines = load_rig(rig).text.splitlines(keepends=True)
    return lambda world, path: path.write_text("".join(x for x in lines if not any(f"effect: {w}," in x for w in without)))  # type: ignore[return-value]


def _axis_copy(world: World, path: Path) -> None:
    """As the page makes it: a log is of the rig whose name its map gives."""
    path.write_text(load_rig("force_axis").text.replace("name: force_axis", "name: my_axis"))


def _logs(world: World, path: Path) -> None:
    path.mkdir()
    shutil.copy(world.thing("LOG.mcap"), path / "ornl_testbed-20260302-080000.mcap")
    shutil.copy(world.thing("A.mcap"), path / "ornl_testbed-20260303-080000.mcap")


def _columns(seed: int) -> dict[str, np.ndarray]:
    """What a laboratory's table of the axis would hold: milliseconds and millimetres."""
    made = axis_logs.simulated(axis_logs.axis_rig(), seed, TABLE_S)
    position_mm = 1e3 * made["axis.position"]
    columns = {"time_ms": 1e3 * made["t_s"], "setpoint_mm": position_mm, "position_mm": position_mm, "drive_V": made["axis.command_V"]}
    return columns | {"temperature": np.full(position_mm.size, 21.0)}


def _table(world: World, path: Path, seed: int) -> None:
    axis_logs.write(path, _columns(seed))


def _matlab(world: World, path: Path) -> None:
    from scipy.io import savemat

    savemat(path, _columns(1))


def _shown_map(world: World, path: Path) -> None:
    """The map that the page prints."""
    shown = next(block for block in blocks(DOCS / "guide" / "rig" / "rig-from-log.md") if block.words == ("yaml",))
    path.write_text("\n".join(shown.lines) + "\n")


def _imported(world: World, path: Path, table: str) -> None:
    for name in (table, "my_map.yaml"):
        world.thing(name)
    world.run(f"longreach import {table} --map my_map.yaml -o {path.name}")


def _benchmark_table(world: World, path: Path, seed: int) -> None:
    """With the column names of the public benchmark."""
    made = axis_logs.simulated(axis_logs.axis_rig(), seed, 12.0)
    columns = {"t_s": made["t_s"], "q_ref_m": made["axis.position"], "q_m": made["axis.position"], "u_V": made["axis.command_V"]}
    axis_logs.write(path, columns | {"force_N": 35.1507 * made["axis.command_V"], "pulse_N": np.zeros_like(made["t_s"])})


def _new_axis(world: World, path: Path) -> None:
    world.run(_shown_command("rig-file.md", "longreach new-rig my_axis"))


def _tutorial_rig(world: World, path: Path) -> None:
    world.run(_shown_command("tutorial-cylinder.md", "longreach new-rig bench"))


def _without_friction(world: World, path: Path) -> None:
    """As the tutorial does."""
    text = world.thing("bench/").joinpath("bench.yaml").read_text().splitlines(keepends=True)
    path.write_text("".join(x for x in text if not any(f"{w}," in x for w in ("coulomb_friction", "stiction", "viscous_friction"))))


def _tutorial_tables(world: World, path: Path) -> None:
    world.run("python -m benchmarks.gap.cylinder_bench cylinder")


def _tutorial_map(world: World, path: Path) -> None:
    for name in ("cylinder/", "bench/"):
        world.thing(name)
    world.run(f"longreach import cylinder/steps.csv --suggest --rig bench/bench.yaml > {path}.made && mv {path}.made {path}")


def _axis_rig(world: World, path: Path) -> None:
    made = world.thing("my_axis/") / "my_axis.yaml"
    path.write_text(made.read_text().replace("name: my_axis", "name: my_rig"))


def _axis_log(world: World, path: Path, seed: int, step: str) -> None:
    text = (world.thing("my_axis/") / "my_axis_joint_steps.yaml").read_text().replace("by: 30 mm", f"by: {step}")
    rig_file = path.parent / "rig-of-the-logs.yaml"
    _axis_rig(world, rig_file)
    (made,) = run_lockstep(load_rig(rig_file), [{"maneuver": {"text": text, "name": "steps"}}], path.with_suffix(".made"), seed)
    made.rename(path)


def _axis_logs(world: World, path: Path) -> None:
    path.mkdir()
    for day, name in ((2, "A.mcap"), (3, "B.mcap")):
        shutil.copy(world.thing(name, "watch-for-wear.md"), path / f"my_rig-2026050{day}-080000.mcap")


def _record(world: World, path: Path) -> None:
    world.thing("my_rig.yaml")
    world.run("longreach identify my_rig.yaml --what payload --out identified.made")
    next((world.folder / "identified.made").glob("my_rig-*.yaml")).rename(path)


def _shown_command(page: str, begin: str) -> str:
    shown = "\n".join(line for block in blocks(next((DOCS / "guide").rglob(page))) for line in block.lines)
    lines = shown.replace("\\\n", " ").splitlines()
    return next(line for line in lines if line.startswith(begin))


def _line(world: World, path: Path) -> None:
    text = (CHECKOUT / "config" / "maneuvers" / "paper_line.yaml").read_text()
    path.write_text(re.sub(r"(?m)^moves: .*", "moves: [12 in, -12 in]", text.replace("name: paper_line", "name: my_line")))


THINGS: dict[str, Callable[[World, Path], None]] = {
    "my_rig.yaml": _rig_file,
    "my_axis.yaml": _axis_copy,
    "RIG.yaml": _shipped("force_axis"),
    "frictionless.yaml": _shipped("force_axis", "coulomb_friction", "valve_null_bias"),
    "found/rig.yaml": _shipped("ornl_testbed"),
    "my_line.yaml": _line,
    "LOG.mcap": _faulty_log,
    "RUN.mcap": _copy("LOG.mcap"),
    "A.mcap": partial(_run_log, seed=1),
    "B.mcap": partial(_run_log, seed=2),
    "monday.mcap": _copy("A.mcap"),
    "tuesday.mcap": _copy("B.mcap"),
    "cold.mcap": partial(_run_log, seed=1, temperature="20 degC"),
    "warm.mcap": _copy("A.mcap"),
    "hot.mcap": partial(_run_log, seed=1, temperature="60 degC"),
    "LOGS/": _logs,
    "logs": _logs,
    "DATA.csv": partial(_table, seed=1),
    "DATA.mat": _matlab,
    "day1.csv": partial(_table, seed=1),
    "day2.csv": partial(_table, seed=2),
    "my_map.yaml": _shown_map,
    "fit.mcap": partial(_imported, table="day1.csv"),
    "hold.mcap": partial(_imported, table="day2.csv"),
    "D/emps_estimation.csv": partial(_benchmark_table, seed=1),
    "D/emps_pulses_test.csv": partial(_benchmark_table, seed=2),
    "my_axis/": _new_axis,
    "bench/": _tutorial_rig,
    "bench/model.yaml": _without_friction,
    "cylinder/": _tutorial_tables,
    "map.yaml": _shown_map,
    "identified/my_rig-2026-11-21.yaml": _record,
}
AN_AXIS: dict[str, Callable[[World, Path], None]] = {
    "my_rig.yaml": _axis_rig,
    "truth.yaml": _axis_rig,
    "A.mcap": partial(_axis_log, seed=1, step="30 mm"),
    "A2.mcap": partial(_axis_log, seed=2, step="30 mm"),
    "B.mcap": partial(_axis_log, seed=3, step="-50 mm"),
    "C.mcap": partial(_axis_log, seed=4, step="40 mm"),
    "D.mcap": partial(_axis_log, seed=5, step="-40 mm"),
    "logs": _axis_logs,
}
# Where "your rig" may be any: an axis, whose searches take seconds.
OF_PAGES = {"find-the-gap.md": AN_AXIS, "watch-for-wear.md": AN_AXIS, "tutorial-cylinder.md": {"map.yaml": _tutorial_map}}
