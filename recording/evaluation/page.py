"""The few pieces of HTML a self-contained page is made of."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

_STYLE = """body{font:15px/1.45 system-ui,sans-serif;max-width:62em;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:.5em 0}td,th{border:1px solid #ccc;padding:.25em .6em;text-align:left;font-size:13px}
tr.alarm td{background:#fbe3e0}pre{background:#f6f6f6;padding:.8em;overflow:auto;font-size:12px}
.verdict{font-size:1.2em;padding:.6em 1em;background:#eef4ee;border-left:5px solid #1f7a4d}
.first h1{font-size:1.3em;margin:.2em 0}.first p{margin:.5em 0}
.open{background:#fbf1e6;border-color:#d68910}img{max-width:100%}svg.plot{width:100%;height:auto}
.wide{overflow-x:auto}p.small{font-size:13px;color:#444}"""


def page(title: str, parts: Sequence[str]) -> str:
    """A whole page; everything it shows is inside it."""
    meta = '<meta charset="utf-8"><meta name="viewport" content="width=device-width">'
    head = f"<head>{meta}<title>{escape(title)}</title><style>{_STYLE}</style></head>"
    body = "\n".join(parts)
    return f'<!doctype html><html lang="en">{head}<body>{body}</body></html>\n'


def table(head: Sequence[str], rows: Sequence[Sequence[Any]], alarms: Sequence[bool] = ()) -> str:
    """Cells are escaped; None is an empty cell. `alarms`: rows to be marked."""
    top = "".join(f"<th>{escape(h)}</th>" for h in head)
    body = "".join(_row(row, k < len(alarms) and alarms[k]) for k, row in enumerate(rows))
    return f'<div class="wide"><table><tr>{top}</tr>{body}</table></div>'


def _row(row: Sequence[Any], alarm: bool) -> str:
    cells = "".join(f"<td>{escape('' if cell is None else str(cell))}</td>" for cell in row)
    return f'<tr class="alarm">{cells}</tr>' if alarm else f"<tr>{cells}</tr>"


def paragraph(text: str, kind: str = "") -> str:
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f"<p>{escape(text)}</p>"


def verdict(good: bool, what: str, why: str = "") -> str:
    """The page's first sentence, marked as good or open."""
    text = f"<b>{escape(what)}</b>" + (f": {escape(why)}" if why else "")
    return f'<p class="verdict{"" if good else " open"}">{text}</p>'


def folded(title: str, inside: str) -> str:
    """Shown on demand."""
    return f"<details><summary>{escape(title)}</summary>{inside}</details>"
