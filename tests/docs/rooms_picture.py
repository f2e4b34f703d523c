"""docs/pictures/rooms.svg from the imports: every folder with its rooms, and which folder imports which.

`python -m tests.docs.rooms_picture` writes it (`make docs` does); a test keeps it equal to the code.
"""

from __future__ import annotations

import ast
import re
from xml.sax.saxutils import escape

from tests.test_rooms import CHECKOUT, FOLDERS, MODULES, arrows, listed

PICTURE = CHECKOUT / "docs" / "pictures" / "rooms.svg"
LEFT, ROW, CHARACTER = 190, 74, 7.2
STYLE = (
    "text{font:12px sans-serif;fill:#222}.f{font-weight:bold;font-size:14px}.s{fill:#555}"
    ".r{fill:#eef3f8;stroke:#9fb4c7}.a{fill:none;stroke:#c2703d}"
)


def picture() -> str:
    """SVG: folders from top to bottom and rooms from left to right; each imports only those below, or to the left."""
    order = list(reversed(FOLDERS))
    height = ROW * len(order) + 40
    width = round(max(_width(folder) for folder in order)) + 20
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">',
        f"<style>{STYLE}</style>",
        f'<rect width="{width}" height="{height}" fill="white"/>',
        *(_arc(order.index(folder), order.index(target)) for folder in order for target in sorted(arrows("")[folder], key=order.index)),
        *(part for number, folder in enumerate(order) for part in _row(number, folder)),
        f'<text class="s" x="{LEFT}" y="{height - 12}">A folder imports only those below it (arcs), a room only those to its left.</text>',
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def says(folder: str) -> str:
    """What lives there: the first clause of the package's docstring."""
    return re.split(r"[.:;]\s", ast.get_docstring(ast.parse(MODULES[folder].read_text())) or "")[0].replace("\n", " ").rstrip(".")


def _middle(row: int) -> float:
    return ROW * row + 34


def _arc(row: int, target: int) -> str:
    """From the importing folder down to the imported one, left of the names; longer ones further out."""
    start, end = _middle(row) + 5, _middle(target) - 5
    out = LEFT - 20 - 20 * (target - row)
    return f'<path class="a" d="M{LEFT - 12},{start} C{out},{start} {out},{end} {LEFT - 12},{end}"/>'


def _width(folder: str) -> float:
    return LEFT + sum(CHARACTER * len(room) + 20 for room in listed(folder))


def _row(row: int, folder: str) -> list[str]:
    y = _middle(row)
    parts = [
        f'<text class="f" x="{LEFT}" y="{y - 10}">{folder}/</text>',
        f'<text class="s" x="{LEFT + 130}" y="{y - 10}">{escape(says(folder))}</text>',
    ]
    x = float(LEFT)
    for room in listed(folder):
        wide = CHARACTER * len(room) + 14
        parts.append(f'<rect class="r" x="{x:.0f}" y="{y}" width="{wide:.0f}" height="24" rx="4"/>')
        parts.append(f'<text x="{x + 7:.0f}" y="{y + 16}">{room}</text>')
        x += wide + 6
    return parts


if __name__ == "__main__":
    PICTURE.write_text(picture())
    print(PICTURE.relative_to(CHECKOUT))
