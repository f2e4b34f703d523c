"""What to do when the operating system refuses a file."""

from __future__ import annotations

import errno
from pathlib import Path

from config.whole_file import refused_by_system


def test_a_folder_that_may_not_be_looked_into_is_advised_on_where_it_can_be_seen(tmp_path: Path) -> None:
    """Too long a name stands for a forbidden folder, which root may enter: asking for anything below it is an error too."""
    forbidden = tmp_path / ("x" * 300)
    error = PermissionError(errno.EACCES, "Permission denied", str(forbidden / "logs" / "a.mcap"))
    assert f"`ls -ld {tmp_path}`" in refused_by_system(error).refusal.next_step
