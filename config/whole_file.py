"""Files appear whole or not at all: written under a temporary name, then renamed. And what to do when the system refuses."""

from __future__ import annotations

import errno
import os
import shlex
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from tempfile import TemporaryFile

from config.errors import LongreachError, UsageError, WriteError

_ROOM = "make room (`df -h` shows where) and try again; what was finished is kept."
_RIGHTS = "Choose another place, or run it as a user who may use this one: `ls -ld {place}` shows who."
_ADVICE = {
    errno.ENOSPC: f"The disk is full: {_ROOM}",
    errno.EDQUOT: f"Your quota is used up: {_ROOM}",
    errno.EFBIG: f"No file may grow that large here (`ulimit -f`): {_ROOM}",
    errno.EACCES: _RIGHTS,
    errno.EPERM: _RIGHTS,
    errno.EROFS: "Nothing can be written there: choose another place.",
    errno.EEXIST: "A file has this name: choose another one; `ls {folder}` shows what is there.",
    errno.ENOTDIR: "A file stands where a folder is needed: `ls {folder}` shows what is there.",
    errno.ENOENT: "Check the path: `ls {folder}` shows what is there.",
}


def system_advice(error: OSError) -> str:
    """What to do about a refusal of the operating system; empty where nothing is known."""
    path = Path(os.fsdecode(error.filename)) if isinstance(error.filename, (str, bytes, os.PathLike)) else Path()
    folder = next((each for each in path.parents if os.path.isdir(each)), Path())  # no error of one that may not be looked into
    path = path if os.path.exists(path) else folder
    return _ADVICE.get(error.errno or 0, "").format(place=shlex.quote(str(path)), folder=shlex.quote(str(folder)))


def refused_by_system(error: OSError) -> LongreachError:
    """A refusal by the operating system as one of ours: which file, why, what to do."""
    where = os.fsdecode(error.filename) if isinstance(error.filename, (str, bytes, os.PathLike)) else ""
    return LongreachError("the operating system refuses", value=error.strerror or str(error), where=where, next_step=system_advice(error))


def free_name(path: Path) -> Path:
    """The first of NAME-2, NAME-3 … beside a file or folder that nothing has yet."""
    return next(name for k in count(2) if not (name := path.with_name(f"{path.stem}-{k}{path.suffix}")).exists())


def refuse_existing(path: Path, what: str, advice: str, name: Path | None = None, option: str = "-o") -> None:
    """UsageError where a file is there that would be lost; a free name for `option` (`name`, where it names several) goes with it."""
    if path.exists():
        raise UsageError(f"the {what} exists already", where=str(path), next_step=advice, mend={option: str(free_name(name or path))})


def refuse_unwritable(folder: Path) -> None:
    """OSError that names the folder, which need not be there yet, where nothing can be written into it: before minutes of work for that."""
    try:
        with TemporaryFile(dir=next(each for each in (folder, *folder.absolute().parents) if each.exists())):
            pass
    except OSError as error:
        error.filename = str(folder)
        raise


@contextmanager
def told_of(path: Path) -> Iterator[None]:
    """A refusal about a temporary name beside the file, or in a temporary folder there, names the file: nobody typed the other."""
    try:
        yield
    except OSError as error:
        if isinstance(error.filename, (str, bytes, os.PathLike)):
            error.filename = _without_temporary(os.fsdecode(error.filename), path)
        raise
    except WriteError as error:
        said = error.refusal
        where = _without_temporary(said.where, path)
        raise WriteError(said.what, value=said.value, where=where, next_step=said.next_step) from error


def _without_temporary(place: str, path: Path) -> str:
    beside, folder = Path(os.path.abspath(place)), Path(os.path.abspath(path.parent))
    temporary = folder in beside.parents and beside.relative_to(folder).parts[0].startswith(".")
    return str(path) if temporary else place


@contextmanager
def replaced_when_done(path: Path) -> Iterator[Path]:
    """The temporary name to write to; the file has its own name when the block ends, and nothing is left of it when that fails.

    OSError when the operating system refuses.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with told_of(path):
            yield temporary
            os.replace(temporary, path)
    finally:
        with suppress(OSError):  # the folder cannot be used: nothing was written there
            temporary.unlink(missing_ok=True)


@contextmanager
def whole_file(path: Path, what: str) -> Iterator[Path]:
    """`replaced_when_done`, its folder made if need be. WriteError "the WHAT cannot be written" when the operating system refuses."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with replaced_when_done(path) as temporary:
            yield temporary
    except OSError as error:
        reason = error.strerror or str(error)
        raise WriteError(f"the {what} cannot be written", value=reason, where=str(path), next_step=system_advice(error)) from error


def write_whole(path: Path, text: str, what: str = "result") -> None:
    """A text file, by `whole_file`."""
    with whole_file(path, what) as temporary:
        temporary.write_text(text, encoding="utf-8")
