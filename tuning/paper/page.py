"""The paper as one self-contained HTML page: acceptance table, figures, misprints. Every number comes from the rows."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from html import escape
from importlib.metadata import version

from matplotlib.figure import Figure

from config.schema.rig import Rig
from tuning.paper.figures import FIGURES
from tuning.paper.figures_motion import figures_9_and_10
from tuning.paper.misprints import MISPRINTS
from tuning.paper.row import ClaimRow

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em; color: #222 }
table { border-collapse: collapse; width: 100%; font-size: 13px }
td, th { border-bottom: 1px solid #ddd; padding: 4px 8px; text-align: left; vertical-align: top }
.pass { color: #176117; font-weight: 600 } .fail { color: #a31515; font-weight: 600 } .note { color: #666 }
img { max-width: 100% } figure { margin: 1.5em 0 }
"""


def paper_page(rig: Rig, rows: Sequence[ClaimRow]) -> str:
    """The page for rows that were computed already; figures are computed here."""
    passed = sum(row.ok for row in rows)
    pictures = [(name, caption, make(rig)) for name, caption, make in FIGURES]
    pictures += figures_9_and_10(rig)[0]
    parts = [
        "<h1>Modeling and control of a hydraulically actuated flexible-prismatic link robot</h1>",
        f"<p>The paper of 1997 computed again by longreach {escape(version('longreach'))} on the rig <code>{escape(rig.name)}</code>:"
        f" <b>{passed} of {len(rows)}</b> rows hold.</p>",
        "<h2>Acceptance table</h2>",
        _table(["row", "claim of the paper", "measured", "target", "tolerance", ""], [_cells(row) for row in rows]),
        "<h2>Figures</h2>",
        *(_figure(name, caption, picture) for name, caption, picture in pictures),
        "<h2>Misprints and doubtful statements</h2>",
        _table(["where", "printed", "right", "shown by"], [_misprint_cells(rows, index) for index in range(len(MISPRINTS))]),
    ]
    head = f"<!doctype html><html lang='en'><meta charset='utf-8'><title>The paper, computed again</title><style>{STYLE}</style>"
    return head + "\n".join(parts) + "</html>\n"


def _cells(row: ClaimRow) -> list[str]:
    note = f"<br><span class='note'>{escape(row.note)}</span>" if row.note else ""
    verdict = "<span class='pass'>holds</span>" if row.ok else "<span class='fail'>fails</span>"
    return [str(row.row), escape(row.claim), escape(row.measured) + note, escape(row.target), escape(row.tolerance), verdict]


def _misprint_cells(rows: Sequence[ClaimRow], index: int) -> list[str]:
    item = MISPRINTS[index]
    shown = next((f"row {row.row}: {row.measured}" for row in rows if row.row == item.row), "reading")
    return [escape(text) for text in (item.where, item.printed, item.right, shown)]


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{text}</th>" for text in heads)
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>\n" for row in rows)
    return f"<table><tr>{head}</tr>\n{body}</table>"


def _figure(name: str, caption: str, picture: Figure) -> str:
    data = io.BytesIO()
    picture.savefig(data, format="png", dpi=80)
    source = base64.b64encode(data.getvalue()).decode("ascii")
    alt = escape(f"{name}: {caption}", quote=True)
    image = f"<img src='data:image/png;base64,{source}' alt=\"{alt}\">"
    return f"<figure>{image}<figcaption><b>{name}.</b> {escape(caption)}</figcaption></figure>"
