"""`new-driver NAME`: a package with a driver of one's own, whose contract test passes as it is written."""

from __future__ import annotations

import argparse
import re
import tempfile
from pathlib import Path


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", help="name of the driver in rig files: lower-case letters, digits and _")
    parser.add_argument("-o", "--out", type=Path, metavar="DIR", help="where the package goes (default ./longreach-NAME)")
    parser.set_defaults(run_command=_new_driver)


def _new_driver(arguments: argparse.Namespace) -> int:
    from config.errors import ConfigError
    from config.options.driver_options import factories
    from config.whole_file import free_name
    from drivers.driver_template import driver_files

    name, folder = arguments.name, arguments.out or Path(f"longreach-{arguments.name}")
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        better = re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_").lstrip("0123456789_") or "my_driver"
        advice = "Use lower-case letters, digits and _, a letter first."
        raise ConfigError("not usable as the name of a driver", value=name, next_step=advice, mend={name: better})
    if name in factories():
        raise ConfigError("a driver of this name is installed", value=name, next_step="Choose another one: `longreach device options`.")
    if folder.exists():
        advice, mend = "Choose another one with --out DIR.", {"--out": str(free_name(folder))}
        raise ConfigError("the folder is there already", value=folder, where="--out", next_step=advice, mend=mend)
    _write(folder, driver_files(name))
    print(f"{folder}: " + ", ".join(driver_files(name)))
    print(f"Next: pip install -e {folder}, pytest {folder}, `longreach device options {name}`; then make the driver speak to your device.")
    return 0


def _write(folder: Path, files: dict[str, str]) -> None:
    """All files or none: they are made beside the folder and put in its place."""
    from config.whole_file import told_of

    folder.parent.mkdir(parents=True, exist_ok=True)
    with told_of(folder), tempfile.TemporaryDirectory(prefix=f".{folder.name}-", dir=folder.parent) as temporary:
        made = Path(temporary) / folder.name
        made.mkdir()
        for name, text in files.items():
            (made / name).write_text(text, encoding="utf-8")
        made.rename(folder)
