"""Residual vibration of every command filter over the frequency error, as a picture."""

from __future__ import annotations

from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from config.whole_file import whole_file
from tuning.shaper_choice.shape_recommendation import Recommendation, Residual

VIBRATION = "largest hold vibration / (m/s²): ideal joints full, whole rig dashed"


def shape_plot(found: Recommendation, out: Path) -> None:
    """PNG. WriteError when it cannot be written."""
    figure = Figure(figsize=(12.0, 7.0), layout="constrained")
    FigureCanvasAgg(figure)
    axis = figure.subplots()
    for candidate in found.candidates:
        if candidate.ideal is None:
            continue
        width, late_s = (3.0 if candidate.kind == found.chosen else 1.2), candidate.judged.late_s
        (line,) = axis.semilogy(*_curve(candidate.ideal), linewidth=width, label=f"{candidate.kind} ({late_s:.2f} s late)")
        if candidate.coupled is not None:
            axis.semilogy(*_curve(candidate.coupled), "o--", linewidth=width, color=line.get_color())
    axis.axhline(found.allowed_mps2, color="black", linestyle=":", label="allowed")
    axis.set(
        xlabel="true link frequency over believed, error / %",
        ylabel=VIBRATION,
        title=found.why,
    )
    axis.grid(alpha=0.3, which="both")
    axis.legend(ncols=2)
    with whole_file(Path(out), "picture") as temporary:
        figure.savefig(temporary, dpi=100, format="png")


def _curve(residual: Residual) -> tuple[list[float], list[float]]:
    return [100.0 * error for error in residual.errors], list(residual.by_error)
