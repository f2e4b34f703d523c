"""report.html: one file that shows where the gap was, what closed it, and what could not be seen."""

from __future__ import annotations

import difflib
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from gap import plots
from gap.found import Found
from gap.localise import operating_values
from gap.measured import Array

_STYLE = """body{font:15px/1.45 system-ui,sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:.5em 0}td,th{border:1px solid #ccc;padding:.25em .6em;text-align:left;font-size:13px}
pre{background:#f6f6f6;padding:.8em;overflow:auto;font-size:12px}
.verdict{font-size:1.2em;padding:.6em 1em;background:#eef4ee;border-left:5px solid #1f7a4d}
.open{background:#fbf1e6;border-color:#d68910}img{max-width:100%}"""


def write_report(found: Found, path: Path) -> None:
    """Write the page; everything it shows is inside it."""
    parts = [
        _head(found),
        _findings(found),
        _places(found),
        _pictures(found),
        _constants(found),
        _not_seen(found),
        _diff(found),
        _inputs(found),
    ]
    body = "\n".join(parts)
    title = escape(f"{found.rig.rig.name}: {found.verdict.word}")
    head = f'<head><meta charset="utf-8"><title>{title}</title><style>{_STYLE}</style></head>'
    path.write_text(f'<!doctype html><html lang="en">{head}<body>{body}</body></html>\n')


def _head(found: Found) -> str:
    calm = "" if found.verdict.confirmed else " open"
    warnings = "".join(f"<p>Data: {escape(problem.text())}</p>" for problem in found.problems)
    said = f'<p class="verdict{calm}"><b>{found.verdict.word}</b>: {escape(found.verdict.why)}</p>'
    return f"<h1>Gap report: {escape(found.rig.rig.name)}</h1>{said}{warnings}"


def _findings(found: Found) -> str:
    rows = []
    for item in found.content["findings"]:
        values = "; ".join(
            f"{key} = {p['value']} {p['unit']} (95%: {p['ci95'][0]} to {p['ci95'][1]})" for key, p in item["parameters"].items()
        )
        alike = ", ".join(f"{x['effect']} at {x['where']} (gain {x['holdout_gain']})" for x in item["look_alikes"]) or "none"
        grade = "confirmed" if item["confirmed"] else "tentative"
        rows.append([f"{item['effect']} at {item['where']}", grade, item["equation"], values, item["holdout_gain"], item["t"], alike])
    if not rows:
        return "<h2>Findings</h2><p>No missing effect is named.</p>"
    sentences = "".join(f"<p>{escape(item['effect'])}: {escape(item['fingerprint'])}</p>" for item in found.content["findings"])
    return "<h2>Findings</h2>" + _table(["effect", "", "equation", "parameters", "gain", "t", "look-alikes"], rows) + sentences


def _places(found: Found) -> str:
    rows = [[p.channel, p.equation, p.region, f"{p.band_Hz[0]:g} to {p.band_Hz[1]:g}", f"{p.share:.0%}"] for p in found.places]
    channels = found.content["gap"]["channels"]
    sizes = [[name, f"{c['before']:.4g}", f"{c['after']:.4g}", c["unit"]] for name, c in channels.items()]
    where = _table(["channel", "equation", "region", "band (Hz)", "share of the gap"], rows) if rows else "<p>Nothing above the noise.</p>"
    return (
        "<h2>Where</h2>" + where + "<h3>Hold-out error in each channel (rms)</h3>" + _table(["channel", "before", "after", "unit"], sizes)
    )


def _pictures(found: Found) -> str:
    names = ["rig file", "constants refitted", *[s.trial.candidate.effect for s in found.state.steps], "as written"]
    gap = found.content["gap"]
    costs = [gap["holdout_before"], gap["holdout_refit"], *[s.trial.cost for s in found.state.steps], gap["holdout_after"]]
    channel = found.channels.index(found.places[0].channel) if found.places else 0
    name = found.channels[channel]
    variable = _variable(found, channel)
    pictures = [
        ("Hold-out gap, step by step", plots.waterfall(names, costs)),
        ("The most revealing window", plots.revealing_window(found.nominal, found.final, channel, name, gap["channels"][name]["unit"])),
        (f"{name}: left over against {variable}", plots.fingerprint(found.nominal, found.final, channel, variable, found.rig.rig)),
        (f"{name}: spectrum of what is left over", plots.spectra(found.nominal, found.final, channel, name)),
    ]
    return "".join(f"<h2>{escape(title)}</h2>{picture}" for title, picture in pictures)


def _variable(found: Found, channel: int) -> str:
    """The operating variable of the strongest region, else the first joint's velocity."""
    region = found.places[0].region if found.places else ""
    known: dict[str, Array] = dict(operating_values(found.nominal[0], found.rig.rig))
    return next((name for name in known if region.startswith(name + " ")), next(iter(known)))


def _constants(found: Found) -> str:
    rows = []
    for key, c in found.content["parameters"].items():
        pull = (c["value"] - c["prior"]["value"]) / c["prior"]["sd"]
        if np.abs(pull) > 0.5:
            rows.append([key, c["prior"]["value"], c["value"], c["unit"], f"{pull:+.1f}", "left its prior" if c["alarm"] else ""])
    table = (
        _table(["constant", "rig file", "refitted", "unit", "prior sd", ""], rows)
        if rows
        else "<p>None moved by more than half a standard deviation.</p>"
    )
    return f"<h2>Constants</h2>{table}"


def _not_seen(found: Found) -> str:
    rows = [[r["effect"], r["where"], r["parameter"], r["smallest_visible"], r["unit"]] for r in found.content["not_seen"]]
    return "<h2>Not seen</h2><p>Smallest size that these logs would have shown.</p>" + _table(
        ["effect", "where", "parameter", "smallest visible", "unit"], rows
    )


def _diff(found: Found) -> str:
    lines = difflib.unified_diff(found.rig.text.splitlines(), found.improved_text.splitlines(), "rig file", "improved", lineterm="", n=1)
    text = "\n".join(lines) or "The rig file is unchanged."
    return f"<h2>Improved rig file</h2><pre>{escape(text)}</pre>"


def _inputs(found: Found) -> str:
    rows = [[i["file"], i["sha256"]] for i in found.content["inputs"]]
    return f"<h2>Inputs</h2>{_table(['file', 'SHA-256'], rows)}<p>{escape(found.content['software'])}</p>"


def _table(head: list[str], rows: list[list[Any]]) -> str:
    top = "".join(f"<th>{escape(h)}</th>" for h in head)
    body = "".join("<tr>" + "".join(f"<td>{escape('' if cell is None else str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{top}</tr>{body}</table>"
