"""Opens a self-contained page in headless Chromium; the tests skip where there is none."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from tests.support.live.browser import browser, console_errors, resize

PLOTS = "return [...document.querySelectorAll('svg.plot')].map(e => { const r = e.getBoundingClientRect(); return [r.width, r.height]; })"


class Opened(NamedTuple):
    """`console`: what the page's console said. `plots`: width and height of every plot as shown; `width`: of the whole page, px."""

    console: list[str]
    plots: list[tuple[float, float]]
    width: int


def opened(page: Path, directory: Path, width: int) -> Opened:
    with browser(directory, width) as chromium:
        resize(chromium, width)
        chromium.get(page.as_uri())
        plots = [(shown[0], shown[1]) for shown in chromium.execute_script(PLOTS)]
        return Opened(console_errors(chromium), plots, int(chromium.execute_script("return document.documentElement.scrollWidth")))


def outside_links(page: Path) -> list[str]:
    """What the page would fetch: none in a self-contained one. References inside the page and the names of XML are none."""
    return re.findall(r"""(?:src|href)=["'](?!#|data:)[^"']+|@import[^;]+|url\((?!#|data:|"#)[^)]+""", page.read_text())
