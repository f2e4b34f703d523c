"""Lists the files of everything longreach needs to run, as installed in the environment of the Python that runs this.

Relative to site-packages, one a line, for tar -T. Test and development tools are left out, and so is longreach itself unless `--whole`
asks for it: where a wheel was installed there is nothing else to take it from.
"""

from __future__ import annotations

import sys
from importlib.metadata import Distribution, distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name


def closure(name: str, extras: frozenset[str], found: dict[str, Distribution]) -> None:
    """Adds the distribution and, recursively, what it requires on this platform."""
    for text in distribution(name).requires or ():
        required = Requirement(text)
        if required.marker and not any(required.marker.evaluate({"extra": extra}) for extra in extras | {""}):
            continue
        key = canonicalize_name(required.name)
        if key not in found:
            found[key] = distribution(key)
            closure(key, frozenset(required.extras), found)


def main() -> None:
    found = {"longreach": distribution("longreach")} if "--whole" in sys.argv[1:] else {}
    closure("longreach", frozenset(), found)
    for each in found.values():
        for file in each.files or ():
            if ".." not in file.parts and Path(str(each.locate_file(file))).is_file():
                print(file)


if __name__ == "__main__":
    main()
