"""A matplotlib figure inside a page."""

from __future__ import annotations

import base64
import io
from html import escape

from matplotlib.figure import Figure


def inline(figure: Figure, says: str) -> str:
    """As a PNG in the page itself; `says`: what a reader who does not see it is told."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return f'<img alt="{escape(says)}" src="data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}">'
