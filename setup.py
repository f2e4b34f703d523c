"""Writes the commit into what is built: an installed copy has no history to ask, and every log names it. The rest: pyproject.toml."""

from __future__ import annotations

import subprocess
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

HERE = Path(__file__).parent
PLACE = Path("daemon", "commit.txt")


def write_commit(folder: Path) -> None:
    """Where the sources were unpacked from such an archive the file is there already."""
    if not (HERE / ".git").exists():
        return
    command = ["git", "-C", str(HERE), "describe", "--always", "--abbrev=12", "--dirty=+", "--exclude=*"]
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    if found.returncode == 0:
        (folder / PLACE).write_text(found.stdout)


class Built(build_py):
    def run(self) -> None:
        super().run()
        if not self.editable_mode:
            write_commit(Path(self.build_lib))


class Archived(sdist):
    def make_release_tree(self, base_dir: str, files: list[str]) -> None:
        super().make_release_tree(base_dir, files)
        write_commit(Path(base_dir))


setup(cmdclass={"build_py": Built, "sdist": Archived})
