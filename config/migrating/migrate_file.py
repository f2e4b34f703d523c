"""Rewrites a rig file in place: the old one is kept beside it, and the new one takes its name only when it holds everything."""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass
from pathlib import Path

from config.errors import ConfigError
from config.migrating.migrations import Migrated, migrated
from config.whole_file import replaced_when_done

BOM = "\ufeff"


@dataclass(frozen=True, slots=True)
class MigratedFile:
    """`backup`: where the old file is; None where nothing had to be rewritten."""

    path: Path
    backup: Path | None
    done: tuple[Migrated, ...]

    def text(self) -> str:
        if self.backup is None:
            return f"{self.path}: nothing to migrate"
        count = f"{len(self.done)} place{'s' * (len(self.done) != 1)}"
        return "\n".join([f"{self.path}: {count} rewritten, the old file is {self.backup}", *(f"  {d.text()}" for d in self.done)])


def migrate_file(path: Path) -> MigratedFile:
    """ConfigError where the file is no UTF-8 YAML or cannot be written; it is then as it was."""
    path = path.resolve()  # a link stays a link
    try:
        written = path.read_bytes().decode("utf-8")
        text, done = migrated(written.removeprefix(BOM), str(path))
        if not done:
            return MigratedFile(path, None, ())
        backup = _backup(path)
        _replace(path, (BOM if written.startswith(BOM) else "") + text)
    except UnicodeDecodeError as error:
        raise ConfigError("the file is not UTF-8 text", where=str(path), next_step="Save it as UTF-8.") from error
    except OSError as error:
        advice = "Copy it to where it can be written, and migrate the copy."
        raise ConfigError("the file cannot be migrated", value=error.strerror or str(error), where=str(path), next_step=advice) from error
    return MigratedFile(path, backup, tuple(done))


def _backup(path: Path) -> Path:
    """A copy under a free name: RIG.yaml.old, RIG.yaml.old-2, …"""
    for number in range(1, 10_000):
        copy = path.with_name(f"{path.name}.old" if number == 1 else f"{path.name}.old-{number}")
        try:
            os.close(os.open(copy, os.O_WRONLY | os.O_CREAT | os.O_EXCL))
        except FileExistsError:
            continue
        shutil.copy2(path, copy)
        return copy
    raise ConfigError("no free name for the old file", where=str(path), next_step="Move old copies away.")


def _replace(path: Path, text: str) -> None:
    with replaced_when_done(path) as temporary:
        temporary.write_bytes(text.encode())
        shutil.copymode(path, temporary)
