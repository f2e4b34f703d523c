"""Names of files to write, as options take them: of the kind that is written, so that a slip replaces no log and no rig file."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path


def output_file(*endings: str) -> Callable[[str], Path]:
    """An argparse type: a file that ends with one of `endings`; the first is proposed for one that does not."""

    def read(text: str) -> Path:
        path = Path(text)
        if path.is_dir():
            raise argparse.ArgumentTypeError(f"{text!r} is a folder: nearest is {path / ('out' + endings[0])}")
        if path.suffix.lower() not in endings:
            near = path.with_name(path.name + endings[0]) if path.exists() else path.with_suffix(endings[0])
            raise argparse.ArgumentTypeError(f"{text!r} is another kind of file (limit: {', '.join(endings)}): nearest is {near}")
        return path

    return read


PICTURE = output_file(".png")
RIG_FILE = output_file(".yaml", ".yml")
