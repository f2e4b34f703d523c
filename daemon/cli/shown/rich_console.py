"""The console of the commands that show a large table; rich takes a tenth of a second to load, so quick commands do without."""

from __future__ import annotations

from rich.console import Console


def console() -> Console:
    return Console(highlight=False, soft_wrap=True, emoji=False)  # `file.yaml:100:5` has an emoji's name in it
