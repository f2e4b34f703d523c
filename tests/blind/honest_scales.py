"""`python -m tests.blind.honest_scales`: how large discrepancy and shares of other friction are where nothing is missing.

Machines of other code than the product's, with friction of every form and nothing missing, on development seeds: a servo axis of
Maxwell-slip elements (tests.support.gap.maxwell_axis; one that yields at once stands for rigid friction) and the blind study's testbed
(Maxwell-slip, rigid and bristle). Constants alone are fitted with priors of δ and η that are next to flat. A half-normal's scale of largest
likelihood is the root mean square of what is found, of η and of δ in every channel, over the machines whose friction has another form than
the model's bristle: every real one has. `--write` puts both into gap/evidence/deciding_numbers.py.
"""

from __future__ import annotations

import argparse
import re
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.gap.deciding_numbers import scaled
from config.loading.load import LoadedRig, load_rig, rig_from_text
from gap.data.experiments import experiments_of
from gap.data.measured import load
from gap.evidence import deciding_numbers
from gap.evidence.opening import opening
from gap.evidence.stages import refitted
from gap.fitting.nuisance import nuisances
from gap.settings import Settings
from tests.blind.cases import FIT, HOLDOUT, RIG
from tests.blind.truth.friction import BRISTLE, RIGID, SLIP
from tests.blind.truth.session import Setting, record
from tests.support.gap import axis_logs
from tests.support.gap.maxwell_axis import maxwell_axis

FLAT = 30.0  # times the present scales: a prior that says next to nothing
AXIS_S = 10.0
NUMBERS = Path(deciding_numbers.__file__)


@dataclass(frozen=True, slots=True)
class Left:
    """What a right model leaves of one machine: `share` η, and δ of every channel as a part of what its signal does. `another`: whether
    the friction has another form than the model's."""

    machine: str
    another: bool
    share: float
    parts: tuple[float, ...]


def main() -> int:
    """Prints a Markdown table and both scales."""
    parser = argparse.ArgumentParser(prog="python -m tests.blind.honest_scales", description=__doc__)
    parser.add_argument("--axes", type=int, default=18, metavar="N", help="simulated axes (default %(default)s)")
    parser.add_argument("--testbeds", type=int, default=3, metavar="N", help="simulated testbeds, half a minute each (default %(default)s)")
    parser.add_argument("--seed", type=int, default=930_000, help="of the first machine (default %(default)s)")
    parser.add_argument("--write", action="store_true", help=f"put the scales into {NUMBERS.name}")
    arguments = parser.parse_args()
    found = []
    print("| machine | η | δ of every channel, of what its signal does |\n|---|---|---|")
    with scaled("OTHER_FORM", FLAT), scaled("HONEST", FLAT):
        for left in (*axes(arguments.axes, arguments.seed), *testbeds(arguments.testbeds, arguments.seed)):
            found.append(left)
            print(f"| {left.machine} | {left.share:.3f} | {', '.join(f'{part:.2g}' for part in left.parts)} |", flush=True)
    another = [left for left in found if left.another]
    numbers = {"OTHER_FORM": _scale([a.share for a in another]), "HONEST": _scale([part for a in another for part in a.parts])}
    print(", ".join(f"{name} = {value}" for name, value in numbers.items()))
    if arguments.write:
        written(numbers)
    return 0


def axes(count: int, seed: int) -> Iterator[Left]:
    """Every third with the model's own bristle, every third with one element that yields at once, every third with 2 to 6 elements."""
    text = axis_logs.axis_text()
    loaded = LoadedRig(rig_from_text(text), text, "axis.yaml")
    for k in range(count):
        draw = np.random.default_rng(seed + k)
        ways = (1e-6,) if k % 3 == 1 else tuple(10.0 ** draw.uniform(-5, -3, int(draw.integers(2, 7))))
        name = f"axis {seed + k}: " + ("bristle" if k % 3 == 0 else "elements of " + ", ".join(f"{1e6 * way:.0f}" for way in ways) + " um")

        def made(take: int, k: int = k, ways: tuple[float, ...] = ways) -> axis_logs.Columns:
            own = seed + 10 * k + take
            return axis_logs.simulated(loaded.rig, own, AXIS_S) if k % 3 == 0 else maxwell_axis(own, AXIS_S, break_away_m=ways)

        yield _left(name, k % 3 != 0, loaded, lambda folder, made=made: [axis_logs.write(folder / f"{n}.csv", made(n)) for n in (0, 1)])


def testbeds(count: int, seed: int) -> Iterator[Left]:
    """Jittered constants, the three forms in turn."""
    loaded = load_rig(RIG)
    for k in range(count):
        form = (SLIP, RIGID, BRISTLE)[k % 3]
        setting = Setting(seed + k, friction_form=form)

        def recorded(folder: Path, setting: Setting = setting) -> list[Path]:
            paths = [folder / "fit.csv", folder / "holdout.csv"]
            for take, (path, (kinds, duration_s)) in enumerate(zip(paths, (FIT, HOLDOUT), strict=True)):
                record(loaded.rig, setting, kinds, duration_s, take, path)
            return paths

        name = {SLIP: "Maxwell slip", RIGID: "rigid", BRISTLE: "bristle"}[form]
        yield _left(f"testbed {seed + k}: {name}", form != BRISTLE, loaded, recorded)


def _left(machine: str, another: bool, loaded: LoadedRig, made: Callable[[Path], Sequence[Path]]) -> Left:
    with tempfile.TemporaryDirectory() as folder:
        logs = [load(path, loaded.rig) for path in made(Path(folder))]
    names, experiments, _ = experiments_of(loaded, logs[:1], logs[1:], Settings(workers=1))
    search = opening(loaded.rig, nuisances(loaded, frozenset(names)), experiments, names)
    at, scales = refitted(search, lambda line: None).null.at.discrepancy, search.seen.scales
    seen = scales > deciding_numbers.LEAST_DISCREPANCY
    return Left(machine, another, at.share, tuple(float(part) for part in (at.sd / scales * deciding_numbers.HONEST)[seen]))


def _scale(values: Sequence[float]) -> float:
    """Of the half-normal under which values have the largest likelihood."""
    return float(f"{np.sqrt(np.mean(np.square(values))):.2g}")


def written(numbers: dict[str, float]) -> None:
    """Each number's line with its new value."""
    text = NUMBERS.read_text()
    for name, value in numbers.items():
        text = re.sub(rf"^{name} = [0-9.e-]+", f"{name} = {value}", text, flags=re.MULTILINE)
    NUMBERS.write_text(text)


if __name__ == "__main__":
    raise SystemExit(main())
