"""`python -m benchmarks.gap.imitation [--picture FILE]`: an effect beside the constant that imitates it, over the effect's true size.

The rig file of a servo axis lacks Coulomb friction; the simulated machine has some. More viscous friction, of which the file is not sure
([A]), brakes as well. A row a size: ln Z of the set with the friction above that of constants alone, what every suspect has to gain for
even odds, P(friction), and where the viscous friction ends beside either.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from benchmarks.gap.deciding_numbers import finished
from config.loading.load import LoadedRig, rig_from_text
from gap.data.measured import load
from gap.evidence.score.hypothesis import Hypothesis
from tests.support.gap import axis_logs

SIZES_N = (0.02, 0.03, 0.04, 0.05, 0.07, 0.1, 0.2, 0.5, 1.0)
NAME, CONSTANT = "coulomb_friction at axis", "plant.effects.0.coefficient"
STATED = 203.5  # N s/m, in rig file and machine
SEED, SECONDS = 951_000, 8.0


@dataclass(frozen=True, slots=True)
class Weighed:
    """One size: what the name gains, what it needs, its probability, and the viscous friction of either model (N s/m)."""

    size_N: float
    gain: float
    needed: float
    probability: float
    alone: float
    beside: float


def main() -> int:
    """Prints a Markdown table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gap.imitation", description=__doc__)
    parser.add_argument("--picture", type=Path, metavar="FILE", help="also draw it")
    arguments = parser.parse_args()
    print("| true friction (N) | ln Z above constants alone | needed | P | viscous, alone (N s/m) | beside the name |")
    print("|---|---|---|---|---|---|")
    rows = []
    for size_N in SIZES_N:
        rows.append(row := weighed(size_N))
        numbers = f"{row.gain:+.1f} | {row.needed:.1f} | {row.probability:.2f} | {row.alone:.1f} | {row.beside:.1f}"
        print(f"| {row.size_N:g} | {numbers} |", flush=True)
    if arguments.picture:
        drawn(rows).savefig(arguments.picture, dpi=110)
    return 0


def weighed(size_N: float) -> Weighed:
    """The search on a log of the machine with so much friction."""
    file = axis_logs.axis_text("coulomb_friction").replace("203.5 N*s/m}  # [B]", "203.5 N*s/m}  # [A]")
    machine = rig_from_text(axis_logs.axis_text().replace("friction: 20.39 N", f"friction: {size_N} N"))
    loaded = LoadedRig(rig_from_text(file), file, "axis.yaml")
    with tempfile.TemporaryDirectory() as folder:
        log = load(axis_logs.write(Path(folder) / "log.csv", axis_logs.simulated(machine, SEED, SECONDS)), loaded.rig)
    search = finished(loaded, [log], [])
    named = search.known(frozenset({NAME}))
    gain, beside = (named.log_z - search.null.log_z, viscous(named)) if named else (float("nan"), float("nan"))
    return Weighed(size_N, gain, -search.log_odds, search.posterior.of(NAME), viscous(search.null), beside)


def viscous(fitted: Hypothesis) -> float:
    """N s/m, as the set's fit has it."""
    return float(next(value for free, value in zip(fitted.model.free, fitted.model.theta, strict=True) if free.key == CONSTANT))


def drawn(rows: Sequence[Weighed]) -> Figure:
    """Evidence above, the constant below."""
    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    sizes = [row.size_N for row in rows]
    above.axhline(rows[0].needed, color="0.5", linestyle="--", label="needed for even odds")
    above.plot(sizes, [row.gain for row in rows], "o-", label="with friction, above constants alone")
    above.set(ylabel="ln Z", yscale="symlog", title="Friction that the file lacks, or more viscous friction?")
    above.legend(fontsize=8)
    below.axhline(STATED, color="0.5", linestyle="--", label="true")
    below.plot(sizes, [row.alone for row in rows], "o-", label="constants alone")
    below.plot(sizes, [row.beside for row in rows], "s-", label="beside the friction")
    below.set(ylabel="viscous friction (N s/m)", xlabel="true Coulomb friction (N)", xscale="log")
    below.set_xticks(sizes, [f"{size:g}" for size in sizes])
    below.minorticks_off()
    below.legend(fontsize=8)
    return figure


if __name__ == "__main__":
    raise SystemExit(main())
