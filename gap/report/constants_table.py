"""The table of the rig file's constants: what was believed, what the improved file has, what each log says."""

from __future__ import annotations

from typing import Any

from config.readable import number
from gap.outcome.file_units import FileUnits, Shown
from gap.outcome.found import Found
from gap.report.headline import pull
from recording.evaluation.page import folded, paragraph, table

HEAD = ["constant", "rig file ± prior sd", "improved file", "95%", "", "unit", "pull (sd)", "each log by itself ± se", ""]
_OTHER = 4  # column of the other values there are: of the fit logs alone where the file has those of all logs


def constants_table(found: Found, units: FileUnits) -> str:
    ranked = sorted(found.content["parameters"].items(), key=lambda item: -pull(item[1]))
    if not ranked:
        return "<h2>Constants</h2>" + paragraph("The logs see none of the rig file's constants.")
    name, other = _others(found)
    head = [*HEAD[:_OTHER], name, *HEAD[_OTHER + 1 :]]
    rows = [_row(key, c, other.get(key, c["value"]), units.constant(key, c["unit"])) for key, c in ranked]
    alarms = [c["alarm"] for _, c in ranked]
    said = "What the logs say of the rig file's constants, those pulled most first; the others are not seen beyond their priors."
    several = sum(pull(c) > 0.5 or c["alarm"] for _, c in ranked)
    shown = table(head, rows[:several], alarms[:several]) if several else paragraph("None is pulled by more than half of its prior.")
    return f"<h2>Constants</h2>{paragraph(said)}{shown}" + folded("The others", table(head, rows[several:]))


def _others(found: Found) -> tuple[str, dict[str, float]]:
    """What else is known of the constants, by key, and its name."""
    if found.with_all_logs is not None:
        return "by the fit logs alone", {k: c["fit_logs"]["value"] for k, c in found.content["parameters"].items() if "fit_logs" in c}
    model = found.state.current.model
    return "all constants free", {free.key: float(value) for free, value in zip(model.free, model.theta, strict=True)}


def _row(key: str, c: dict[str, Any], other: float, shown: Shown) -> list[str]:
    prior = f"{_number(shown, c['prior']['value'])} ± {number(abs(shown.factor) * c['prior']['sd'])} [{c['prior']['tag'] or 'no tag'}]"
    span, elsewhere = shown.span(c["ci95"]), "" if abs(other - c["value"]) <= 1e-5 * abs(other) else _number(shown, other)
    alarm = "left its prior" if c["alarm"] else ""
    return [key, prior, _number(shown, c["value"]), span, elsewhere, shown.unit, f"{pull(c):.1f}", _by_log(c, shown), alarm]


def _number(shown: Shown, value: float) -> str:
    return number(float(shown.of(value)))


def _by_log(constant: dict[str, Any], shown: Shown) -> str:
    """A changed constant as every log by itself has it."""
    if "by_log" not in constant:
        return ""
    values = (f"{row['file']}: {_number(shown, row['value'])} ± {number(abs(shown.factor) * row['se'])}" for row in constant["by_log"])
    return f"{'; '.join(values)} (p = {constant['p']:.2g})"
