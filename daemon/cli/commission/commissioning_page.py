"""The commissioning report: one self-contained page with every step's record."""

from __future__ import annotations

from html import escape
from pathlib import Path

from config.whole_file import write_whole
from daemon.cli.commission.record import Commissioning, StepRecord
from daemon.cli.commission.steps import STEPS, CommissionStep
from recording.evaluation.page import folded, page, paragraph, table, verdict

PAGE = "commissioning.html"


def write_page(commissioning: Commissioning, rig_text: str) -> Path:
    out = commissioning.folder / PAGE
    write_whole(out, commissioning_page(commissioning, rig_text))
    return out


def commissioning_page(commissioning: Commissioning, rig_text: str) -> str:
    records = commissioning.records
    failed = [name for name, record in records.items() if record.outcome.passed is False]
    missing = [step.name for step in STEPS if step.name not in records]
    good = not failed and not missing
    what = "commissioned" if good else f"{len(records) - len(failed)} of {len(STEPS)} steps are done"
    why = "; ".join(
        part for part in (f"not passed: {', '.join(failed)}" if failed else "", f"to do: {', '.join(missing)}" if missing else "") if part
    )
    rows = [_row(number, step, records.get(step.name)) for number, step in enumerate(STEPS, 1)]
    alarms = [step.name in failed for step in STEPS]
    parts = [f"<h1>Commissioning of {escape(commissioning.rig_name)}</h1>", verdict(good, what, why),
             table(["", "step", "", "date (UTC)", "by", "on", "explained in"], rows, alarms)]  # fmt: skip
    parts += [_details(number, step, records[step.name]) for number, step in enumerate(STEPS, 1) if step.name in records]
    parts.append(folded("The rig file", f"<pre>{escape(rig_text)}</pre>"))
    return page(f"Commissioning of {commissioning.rig_name}", parts)


def _row(number: int, step: CommissionStep, record: StepRecord | None) -> list[object]:
    if record is None:
        return [number, step.name, "to do", "", "", "", step.page]
    return [number, step.name, record.outcome.word, record.date_utc[:19].replace("T", " "), record.by, record.on, step.page]


def _details(number: int, step: CommissionStep, record: StepRecord) -> str:
    outcome = record.outcome
    rows = [[value.what, value.value, value.limit, "" if value.ok else "NO"] for value in outcome.values]
    files = [f"{kind}: {', '.join(names)}" for kind, names in (("logs", outcome.logs), ("files", outcome.files)) if names]
    return (
        f"<h2>{number}. {escape(step.name)}</h2>"
        + paragraph(outcome.text)
        + (table(["", "value", "limit", ""], rows, [not value.ok for value in outcome.values]) if rows else "")
        + "".join(paragraph(line, "small") for line in files)
    )
