"""What to do when the operating system refuses a file."""

from __future__ import annotations

import errno
import tempfile
from pathlib import Path

import pytest

from config.errors import WriteError
from config.whole_file import refuse_unwritable, refused_by_system, replaced_when_done, told_of


def test_a_folder_that_may_not_be_looked_into_is_advised_on_where_it_can_be_seen(tmp_path: Path) -> None:
    """Too long a name stands for a forbidden folder, which root may enter: asking for anything below it is an error too."""
    forbidden = tmp_path / ("x" * 300)
    error = PermissionError(errno.EACCES, "Permission denied", str(forbidden / "logs" / "a.mcap"))
    assert f"`ls -ld {tmp_path}`" in refused_by_system(error).refusal.next_step


def test_a_refusal_names_the_file_that_was_asked_for_and_not_its_temporary_name(tmp_path: Path) -> None:
    wanted = tmp_path / "rec.mcap"
    with pytest.raises(WriteError) as refused, replaced_when_done(wanted) as temporary:
        raise WriteError("the log cannot be written", value="No space left on device", where=str(temporary), next_step="Make room.")
    assert (refused.value.refusal.where, refused.value.refusal.next_step) == (str(wanted), "Make room.")
    with pytest.raises(FileNotFoundError) as by_system, replaced_when_done(wanted) as temporary:
        (temporary / "table").open("w")
    assert by_system.value.filename == str(wanted)


def test_another_file_keeps_its_name(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as refused, told_of(tmp_path / "a" / "rec.mcap"):
        (tmp_path / ".b" / "source.csv").open()
    assert refused.value.filename == str(tmp_path / ".b" / "source.csv")


def test_a_file_where_a_folder_is_needed_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "fit.mcap").write_text("")
    monkeypatch.chdir(tmp_path)
    for out in ("fit.mcap", "fit.mcap/deeper"):
        with pytest.raises(NotADirectoryError) as refused:
            refuse_unwritable(Path(out))
        assert refused.value.filename == out
    refuse_unwritable(tmp_path / "new" / "folder")
    assert [path.name for path in tmp_path.iterdir()] == ["fit.mcap"]


def test_a_temporary_folder_that_cannot_be_made_is_not_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(NotADirectoryError) as refused, told_of(tmp_path / "file" / "b.mcap"):
        tempfile.mkdtemp(prefix=".longreach-", dir=tmp_path / "file")
    assert refused.value.filename == str(tmp_path / "file" / "b.mcap")
