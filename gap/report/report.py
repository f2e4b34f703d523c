"""report.html: one file that shows where the gap was, what closed it, and what could not be seen. Every cost is of the hold-out."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

from config.load import rig_from_text
from gap.report import plots
from gap.report.found import Found
from gap.report.kept_sentence import kept_sentence
from gap.report.naming_record import how_often_right, named_of
from gap.report.page import folded, page, paragraph, table
from gap.report.remainder import sentence
from gap.report.replay import SMOOTH_S, replays
from gap.report.shown import fingerprints, stages, telling_channel, unit_of_channel
from gap.report.unseen import Unseen
from gap.search.search_state import Step
from tuning.record_file import write_whole


def write_report(found: Found, path: Path, unseen: Sequence[Unseen] = (), request: Path | None = None) -> None:
    """Write the page. `request`: the first hold-out's run, where that log does not hold it."""
    parts = [_head(found), _findings(found), _next(found), _places(found), _shrink(found), _remainder(found), _unseen(unseen),
             _fingerprints(found), _spectra(found), _replay(found, request), _constants(found), _not_seen(found), _diff(found),
             _inputs(found)]  # fmt: skip
    write_whole(path, page(f"{found.rig.rig.name}: {found.verdict.word}", parts))


def _head(found: Found) -> str:
    sure = found.verdict.confirmed and not any(step.weak for step in found.state.steps)
    calm = "" if sure else " open"
    warnings = "".join(paragraph(f"Data: {problem.text()}", "small") for problem in found.problems)
    said = f'<p class="verdict{calm}"><b>{found.verdict.word}</b>: {escape(found.verdict.why)}</p>'
    return f"<h1>Gap report: {escape(found.rig.rig.name)}</h1>{said}{warnings}"


def _findings(found: Found) -> str:
    rows, notes = [], []
    records = [_record(found, step) for step in found.state.steps]
    records += ["Read off the logs, not fitted."] * len(found.state.coarse)
    for item, record in zip(found.content["findings"], records, strict=True):
        values = "; ".join(
            f"{key} = {p['value']} {p['unit']} (95%: {p['ci95'][0]} to {p['ci95'][1]})" for key, p in item["parameters"].items()
        )
        alike = ", ".join(f"{x['effect']} at {x['where']} (gain {x['holdout_gain']})" for x in item["look_alikes"]) or "none"
        grade = "confirmed" if item["confirmed"] else "tentative"
        rows.append([f"{item['effect']} at {item['where']}", grade, item["equation"], values, item["holdout_gain"], item["t"], alike])
        notes.append(paragraph(f"{item['effect']} at {item['where']}: {item['fingerprint']} {record}"))
    if not rows:
        return "<h2>Findings</h2>" + paragraph("No missing effect is named.")
    return "<h2>Findings</h2>" + table(["effect", "", "equation", "parameters", "gain", "t", "look-alikes"], rows) + "".join(notes)


def _record(found: Found, step: Step) -> str:
    """How often the blind test was right about this effect at this size."""
    chosen = step.trial.candidate
    signatures = found.state.first_screening.signatures if found.state.first_screening else ()
    visible = next((s.smallest_visible for s in signatures if s.candidate.label == chosen.label), 0.0)
    model = step.trial.fit.model
    numbers = model.of_effect(model.added[-1])
    moved = abs(float(model.theta[numbers[0]]) - model.free[numbers[0]].start) if numbers else 0.0
    return how_often_right(chosen.effect, moved / visible if visible > 0 and moved > 0 else None)


def _next(found: Found) -> str:
    proposal = found.content["next_maneuver"]
    if not proposal:
        return ""
    changes = ", ".join(f"{key}: {value}" for key, value in proposal["parameters"].items())
    what = f"{proposal['name']} ({changes})" if changes else proposal["name"]
    return "<h2>Next maneuver</h2>" + paragraph(f"{' or '.join(proposal['separates'])}: {what}: {proposal['why']}.")


def _places(found: Found) -> str:
    rows = [[p.channel, p.equation, p.region, f"{p.band_Hz[0]:g} to {p.band_Hz[1]:g}", f"{p.share:.0%}"] for p in found.places]
    channels = found.content["gap"]["channels"]
    sizes = [[name, f"{c['before']:.4g}", f"{c['after']:.4g}", c["unit"]] for name, c in channels.items()]
    where = (
        table(["channel", "equation", "region", "band (Hz)", "share of the gap"], rows) if rows else paragraph("Nothing above the noise.")
    )
    return "<h2>Where</h2>" + where + "<h3>Error in each channel (rms)</h3>" + table(["channel", "before", "after", "unit"], sizes)


def _shrink(found: Found) -> str:
    """The cost step by step, then the window that shows it best."""
    channel = telling_channel(found)
    name = found.channels[channel]
    window = plots.revealing_window(found.nominal, found.final, channel, name, unit_of_channel(found, name))
    return f"<h2>Gap, step by step</h2>{plots.waterfall(stages(found), found.channels)}<h2>Most revealing window</h2>{window}"


def _remainder(found: Found) -> str:
    """What is left without a name, and whether the improved rig file has it."""
    rest = found.content["remainder"]
    if not rest:
        return ""
    equation = rest["discrepancy"]
    picture = plots.carried(equation) if equation and equation["carried_by"] else ""
    return "<h2>What is left</h2>" + paragraph(f"{sentence(rest)} {kept_sentence(rest)}") + picture


def _unseen(logs: Sequence[Unseen]) -> str:
    if not logs:
        return ""
    rows = [[u.log.path.name, _cost(u.before, u.before_ci95), _cost(u.after, u.after_ci95)] for u in logs]
    said = "These logs fitted nothing and decided nothing. Costs in noise floors."
    return "<h2>Logs never used</h2>" + paragraph(said) + table(["log", "rig file", "improved"], rows)


def _cost(value: float, ci95: tuple[float, float]) -> str:
    return f"{value:.4g} ({ci95[0]:.3g} to {ci95[1]:.3g})"


def _fingerprints(found: Found) -> str:
    pictures = [
        (label, plots.fingerprint(found.nominal, found.final, found.channels.index(what.channel), what, found.rig.rig))
        for label, what in fingerprints(found)
    ]
    return "".join(f"<h2>Fingerprint: {escape(label)}</h2>{picture}" for label, picture in pictures)


def _spectra(found: Found) -> str:
    channel = telling_channel(found)
    name = found.channels[channel]
    return f"<h2>Spectrum of what is left of {escape(name)}</h2>" + plots.spectra(found.nominal, found.final, channel, name)


def _replay(found: Found, request: Path | None) -> str:
    """The first hold-out log's run under the real controller, from the reference."""
    title = "<h2>Closed-loop replay</h2>"
    improved = rig_from_text(found.improved_text, "improved rig.yaml")
    shown = replays(found.state.holdouts[0].log.path, found.rig.rig, improved, request)
    if isinstance(shown, str):
        return title + paragraph(shown)
    said = (
        f"The hold-out's run simulated with the controller, from its reference alone; means over {SMOOTH_S * 1e3:.0f} ms. Difference, rms:"
    )
    rows = [[r.joint, *(f"{v:.3g}" for v in r.rms()[:2]), *(f"{v:.3g} {r.unit}" for v in r.rms()[2:])] for r in shown]
    head = ["joint", "command before (V)", "command after (V)", "tracking error before", "tracking error after"]
    return title + paragraph(said) + table(head, rows) + "".join(plots.closed_loop_replay(r) for r in shown)


def _constants(found: Found) -> str:
    rows, alarms = [], []
    ranked = sorted(found.content["parameters"].items(), key=lambda item: -_pull(item[1]))
    for key, c in ranked:
        prior = f"{c['prior']['value']} ± {c['prior']['sd']:.3g} [{c['prior']['tag'] or 'no tag'}]"
        span = f"{c['ci95'][0]} to {c['ci95'][1]}"
        rows.append([key, prior, c["value"], span, c["unit"], f"{_pull(c):.1f}", _by_log(c), "left its prior" if c["alarm"] else ""])
        alarms.append(c["alarm"])
    if not rows:
        return "<h2>Constants</h2>" + paragraph("The logs see none of the rig file's constants.")
    said = "What the logs say of the rig file's constants, those pulled most first; the others are not seen beyond their priors."
    head = ["constant", "rig file ± prior sd", "refitted", "95%", "unit", "pull (sd)", "each log by itself ± se", ""]
    several = sum(_pull(c) > 0.5 for _, c in ranked)
    shown = table(head, rows[:several], alarms[:several]) if several else paragraph("None is pulled by more than half of its prior.")
    return f"<h2>Constants</h2>{paragraph(said)}{shown}" + folded("The others", table(head, rows[several:]))


def _by_log(constant: dict[str, Any]) -> str:
    """A changed constant as every log by itself has it."""
    if "by_log" not in constant:
        return ""
    values = "; ".join(f"{row['file']}: {row['value']} ± {row['se']}" for row in constant["by_log"])
    return f"{values} (p = {constant['p']:.2g})"


def _pull(constant: dict[str, Any]) -> float:
    return float(abs(constant["value"] - constant["prior"]["value"]) / constant["prior"]["sd"])


def _not_seen(found: Found) -> str:
    """The sizes are what the search says of itself; the blind test says how true that is."""
    sizes = (1.0, 3.0)
    rows = [
        [r["effect"], r["where"], r["parameter"], r["smallest_visible"], r["unit"], *(named_of(k, r["effect"]) for k in sizes)]
        for r in found.content["not_seen"]
    ]
    said = "Effects that were looked for and not named, with the smallest size that these logs would have shown, as the search reckons it."
    if all(every := [named_of(k) for k in sizes]):
        said += f" In the blind test {every[0]} effects of that size were named and {every[1]} of three times it."
    heads = ["effect", "where", "parameter", "smallest visible", "unit", "blind test: named at this size", "at three times it"]
    return "<h2>Not seen</h2>" + paragraph(said) + table(heads, rows)


def _diff(found: Found) -> str:
    lines = difflib.unified_diff(found.rig.text.splitlines(), found.improved_text.splitlines(), "rig file", "improved", lineterm="", n=1)
    text = "\n".join(lines) or "The rig file is unchanged."
    return f"<h2>Improved rig file</h2><pre>{escape(text)}</pre>"


def _inputs(found: Found) -> str:
    rows = [[i["file"], i["sha256"]] for i in found.content["inputs"]]
    return f"<h2>Inputs</h2>{table(['file', 'SHA-256'], rows)}{paragraph(found.content['software'])}"
