"""The table of the rig file's constants: what was believed, what the improved file has, what each log says."""

from __future__ import annotations

from typing import Any

from config.readable import number
from gap.outcome.file_units import FileUnits, Shown
from gap.outcome.found import Found
from gap.report.headline import pull
from recording.evaluation.page import folded, paragraph, table

HEAD = ["constant", "rig file ± prior sd", "improved file", "95%", "all constants free", "unit", "pull (sd)", "each log by itself ± se", ""]


def constants_table(found: Found, units: FileUnits) -> str:
    free = {f.key: float(v) for f, v in zip(found.state.current.model.free, found.state.current.model.theta, strict=True)}
    ranked = sorted(found.content["parameters"].items(), key=lambda item: -pull(item[1]))
    if not ranked:
        return "<h2>Constants</h2>" + paragraph("The logs see none of the rig file's constants.")
    rows = [_row(key, c, free.get(key, c["value"]), units.constant(key, c["unit"])) for key, c in ranked]
    alarms = [c["alarm"] for _, c in ranked]
    said = "What the logs say of the rig file's constants, those pulled most first; the others are not seen beyond their priors."
    several = sum(pull(c) > 0.5 or c["alarm"] for _, c in ranked)
    shown = table(HEAD, rows[:several], alarms[:several]) if several else paragraph("None is pulled by more than half of its prior.")
    return f"<h2>Constants</h2>{paragraph(said)}{shown}" + folded("The others", table(HEAD, rows[several:]))


def _row(key: str, c: dict[str, Any], free: float, shown: Shown) -> list[str]:
    prior = f"{_number(shown, c['prior']['value'])} ± {number(abs(shown.factor) * c['prior']['sd'])} [{c['prior']['tag'] or 'no tag'}]"
    span, elsewhere = shown.span(c["ci95"]), "" if abs(free - c["value"]) <= 1e-5 * abs(free) else _number(shown, free)
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
