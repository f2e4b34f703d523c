"""gap/report/naming_record.yaml, from which every gap report says how often a name was right: single effects, by effect and size."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from gap.report.naming_record import RECORD
from tests.blind.scoring.score import Score, right


def write_record(scores: Sequence[Score], digest: str, path: Path = RECORD) -> None:
    """One line an effect and size. No file without single effects: an older study's tally is not this one's."""
    single = [s for s in scores if s.case.group == "single" and s.case.setting.hidden]
    cases = Counter((s.case.setting.hidden[0].effect, s.case.multiple) for s in single)
    good = Counter((s.case.setting.hidden[0].effect, s.case.multiple) for s in single if right(s))
    rows = [
        f"  - {{effect: {effect}, multiple: {multiple:g}, right: {good[effect, multiple]}, cases: {count}}}\n"
        for (effect, multiple), count in sorted(cases.items())
    ]
    if not rows:
        path.unlink(missing_ok=True)
        return
    head = f"# Written by `make blind`; do not edit. Answers sealed with SHA-256 {digest}. Right: the name first or in its set.\ncases:\n"
    path.write_text(head + "".join(rows))
