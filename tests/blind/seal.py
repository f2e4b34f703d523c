"""Answers in a sealed file: its SHA-256 is published before the run, and nothing is scored when the file no longer has it."""

from __future__ import annotations

import hashlib
import json
import os
import secrets
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from tests.blind.cases import Case


class BrokenSealError(Exception):
    """The answers are not those whose hash was published."""


ANSWERS, HASH = "answers.json", "answers.sha256"


def seal(folder: Path, cases: Sequence[Case], master_seed: int) -> str:
    """Write the answers and their hash into `folder`; refuses to overwrite. Returns the hash.

    A random salt is sealed in, so that the hash cannot be matched by guessing answers.
    """
    folder.mkdir(parents=True, exist_ok=True)
    content = {"salt": secrets.token_hex(16), "master_seed": master_seed, "cases": [case.as_json() for case in cases]}
    text = json.dumps(content, indent=0) + "\n"
    digest = hashlib.sha256(text.encode()).hexdigest()
    with open(os.open(folder / ANSWERS, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
        file.write(text)
    (folder / HASH).write_text(f"{digest}  {ANSWERS}\nsealed {datetime.now(UTC):%Y-%m-%d %H:%M} UTC, {len(cases)} cases\n")
    return digest


def sealed_in(folder: Path) -> Path:
    """Where the answers of a study lie: with its results or, where several searches run the same cases, in the folder above."""
    return folder if (folder / HASH).exists() else folder.parent


def published(study: Path) -> tuple[str, str]:
    """The published hash, and when it was sealed."""
    first, second = (sealed_in(study) / HASH).read_text().splitlines()[:2]
    return first.split()[0], second


def unseal(study: Path) -> list[Case]:
    """The answers. BrokenSealError when the file was changed after its hash was published."""
    folder = sealed_in(study)
    text = (folder / ANSWERS).read_text()
    digest = hashlib.sha256(text.encode()).hexdigest()
    expected, _ = published(folder)
    if digest != expected:
        raise BrokenSealError(f"{folder / ANSWERS} has the hash {digest[:12]}..., published was {expected[:12]}...")
    return [Case.from_json(item) for item in json.loads(text)["cases"]]
