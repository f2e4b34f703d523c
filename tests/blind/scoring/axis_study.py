"""`python -m tests.blind.scoring.axis_study DIR`: development cases of a servo axis, seconds of processor time each.

    python -m tests.blind.scoring.paired DIR OTHER    # of two checkouts

A round has nothing missing under four forms of friction, missing and hidden effects, and numbers of 3 times and a fifth of what is stated.
Constants are jittered, seed by seed. Cases that have a result are not run again. Nothing here is sealed: answers may be looked at.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from gap.settings import Settings
from tests.blind.cases import Case
from tests.blind.one_case import search_files
from tests.blind.result_file import ENDED, gather, of_case, results
from tests.blind.seal import HASH, seal
from tests.blind.truth.friction import BRISTLE, RIGID, SLIP
from tests.blind.truth.session import Hidden, Setting
from tests.support.gap import axis_logs
from tests.support.gap.maxwell_axis import maxwell_axis

LOG_S = 10.0
FRICTION_N, VISCOUS_NS_PER_M, MASS_KG = 20.39, 203.5, 95.1089  # as config/rigs/force_axis.yaml states them
SENSOR = "sensor:axis.position"
# group, hidden effect and place, its value, what the machine's file says instead of the stated line
HIDDEN: tuple[tuple[str, str, str, float], ...] = (
    ("single", "coulomb_friction", "axis", FRICTION_N),
    ("single", "viscous_friction", "axis", VISCOUS_NS_PER_M),
    ("single", "sensor_delay", SENSOR, 0.004),
    ("single", "valve_deadband", "axis", 0.02),
    ("changed", "coulomb_friction", "axis", 3.0 * FRICTION_N),
    ("changed", "coulomb_friction", "axis", FRICTION_N / 5.0),
    ("changed", "viscous_friction", "axis", 3.0 * VISCOUS_NS_PER_M),
)  # fmt: skip
FIELDS = {"sensor_delay": "delay: {} s", "valve_deadband": "overlap: {}"}


def main() -> int:
    """Exit 0; a line a case."""
    parser = argparse.ArgumentParser(prog="python -m tests.blind.scoring.axis_study", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--group", help="only cases of this group, such as null")
    parser.add_argument("--seed", type=int, default=940_000, help="of the first case (default %(default)s)")
    arguments = parser.parse_args()
    every = list(cases(arguments.rounds, arguments.seed))
    if not (arguments.folder / HASH).exists():
        seal(arguments.folder, every, arguments.seed)
    study: Path = arguments.folder
    (study / ENDED).mkdir(parents=True, exist_ok=True)
    for case in every:
        if case.name not in results(study) and arguments.group in (None, case.group):
            result = searched(case)
            of_case(study, case.name).write_text(json.dumps(result) + "\n")
            print(f"{case.name}: {told(case)}: {answered(result)}", flush=True)
    gather(study)
    return 0


def cases(rounds: int, seed: int) -> Iterator[Case]:
    """`Setting.friction_form` says what rubs; every second effect-free machine has the model's own bristle."""
    number = 0
    for _ in range(rounds):
        for form in (BRISTLE, SLIP, BRISTLE, RIGID):
            yield _case(number, seed, "null", (), form)
            number += 1
        for group, effect, where, value in HIDDEN:
            yield _case(number, seed, group, (Hidden(effect, where, value),), BRISTLE)
            number += 1


def _case(number: int, seed: int, group: str, hidden: tuple[Hidden, ...], form: float) -> Case:
    setting = Setting(seed + 10 * number, hidden, True, form)
    removed = tuple((h.effect, h.where) for h in hidden if group == "single" and h.effect not in FIELDS)
    return Case(f"case-{number:04d}", group, setting, removed, 0.0, ("axis", LOG_S), ("axis", LOG_S))


def searched(case: Case) -> dict[str, Any]:
    """One search of one case on files of its own, as the blind study runs it."""
    with tempfile.TemporaryDirectory(prefix="axis-") as name:
        folder = Path(name)
        (folder / "rig.yaml").write_text(axis_logs.axis_text(*(effect for effect, _ in case.removed)))
        logs = [axis_logs.write(folder / f"{take}.csv", made(case, take)) for take in (0, 1)]
        start = time.process_time()
        found = search_files(folder / "rig.yaml", logs[:1], logs[1:], Settings(workers=1, propose=False))
    return {"name": case.name} | found | {"processor_s": round(time.process_time() - start, 1)}


def made(case: Case, take: int) -> axis_logs.Columns:
    """One log of the hidden machine; `take` draws another maneuver and other noise on it."""
    seed, form = case.setting.seed, case.setting.friction_form
    draw = np.random.default_rng([seed, 7919])
    if form == RIGID:
        return maxwell_axis(seed + take, LOG_S, break_away_m=(1e-6,))
    if form == SLIP:
        return maxwell_axis(seed + take, LOG_S, break_away_m=tuple(10.0 ** draw.uniform(-5, -3, int(draw.integers(2, 7)))))
    return axis_logs.simulated(axis_logs.rig_from_text(machine_text(case, draw)), seed + take, LOG_S)


def machine_text(case: Case, draw: np.random.Generator) -> str:
    """The hidden machine as a rig file: constants jittered, then what is hidden."""
    hidden = {h.effect: h.value for h in case.setting.hidden}
    values = {
        "mass: 95.1089 kg": ("mass: {} kg", MASS_KG * (1.0 + 0.01 * draw.standard_normal())),
        "friction: 20.39 N": ("friction: {} N", hidden.get("coulomb_friction", FRICTION_N) * (1.0 + 0.03 * draw.standard_normal())),
        "coefficient: 203.5 N*s/m": (
            "coefficient: {} N*s/m",
            hidden.get("viscous_friction", VISCOUS_NS_PER_M) * (1.0 + 0.03 * draw.standard_normal()),
        ),
    }
    text = axis_logs.axis_text()
    for stated, (line, value) in values.items():
        text = text.replace(stated, line.format(f"{value:.6g}"))
    more = [h for h in case.setting.hidden if h.effect in FIELDS]
    return text + "".join(f"    - {{effect: {h.effect}, where: {h.where}, {FIELDS[h.effect].format(h.value)}}}\n" for h in more)


def told(case: Case) -> str:
    """What is hidden, in words."""
    form = {BRISTLE: "bristle", SLIP: "Maxwell slip", RIGID: "rigid"}[case.setting.friction_form]
    hidden = ", ".join(f"{h.effect} {h.value:.4g}" for h in case.setting.hidden)
    return f"{case.group}, {form}{', ' if hidden else ''}{hidden}"


def answered(result: dict[str, Any]) -> str:
    """The verdict in a line."""
    names = [f"{f['effect']} at {f['where']}{'' if f['confirmed'] else ' (tentative)'}" for f in result["findings"]]
    return f"{result['verdict']} {', '.join(names)} ({result['processor_s']:.1f} s)"


if __name__ == "__main__":
    raise SystemExit(main())
