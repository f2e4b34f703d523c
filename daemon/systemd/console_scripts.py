"""Writes the commands of the longreach installed beside this Python into its bin folder, as pip does.

For an environment that was copied without pip; the lines are those of the console scripts of other installers (PyPA, entry points).
"""

from __future__ import annotations

import sys
from importlib.metadata import distribution
from pathlib import Path

SCRIPT = """#!{python}
import sys

from {module} import {function}

sys.exit({function}())
"""


def main() -> None:
    for each in distribution("longreach").entry_points.select(group="console_scripts"):
        path = Path(sys.prefix, "bin", each.name)
        path.write_text(SCRIPT.format(python=Path(sys.prefix, "bin", "python"), module=each.module, function=each.attr))
        path.chmod(0o755)


if __name__ == "__main__":
    main()
