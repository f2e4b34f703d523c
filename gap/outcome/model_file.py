"""Writes what was found into the rig file as a human would: the text stays, effects get a line, changed constants a remark."""

from __future__ import annotations

from collections.abc import Sequence

from config.loading.load import apply_overrides
from config.parsing.yaml_tree import entry as entry_in
from config.parsing.yaml_tree import parse
from config.units import from_si, written_unit
from gap.data.coarse_steps import CoarseStep
from gap.data.measured import Array
from gap.fitting.model import Free, Model
from gap.outcome.names import Fitted, numbers_of
from gap.suspects.candidates import Candidate

WORTH_WRITING = 0.5  # prior standard deviations a constant must have moved to be changed in the file


def moved(model: Model, half_width: Array) -> list[int]:
    """Constants that the data moved: the old value lies outside the new one's interval, or half a prior standard deviation away."""
    pairs = zip(model.free, model.theta, half_width, strict=True)
    return [
        k for k, (free, value, width) in enumerate(pairs) if free.prior and abs(value - free.start) > min(width, WORTH_WRITING * free.scale)
    ]


def improved(text: str, model: Model, lines: Sequence[str]) -> str:
    """The rig file's text with the effects' `lines` added and every constant that is no longer as stated; each with where it comes from."""
    pairs = zip(model.free, model.theta, strict=True)
    text = _with_values(text, [(free, float(value)) for free, value in pairs if free.prior and value != free.start])
    for line in lines:
        text = with_effect_line(text, line)
    return text


def effect_line(suspect: Candidate, fitted: Fitted, remark: str) -> str:
    """`- {effect: NAME, where: PLACE, parameter: value unit}  # [gap] why`."""
    model, numbers = fitted.model, numbers_of(suspect, fitted.model)
    entry = model.entry_added(suspect.effect, suspect.where)
    free = {model.free[k].key: f"{written(model.theta[k])} {model.free[k].unit}".strip() for k in numbers}
    given = entry.model_dump(by_alias=True, exclude_unset=True)
    fixed = {key: value for key, value in given.items() if key not in free and key not in ("effect", "where", "quantity_kind")}
    values = {"effect": suspect.effect, "where": suspect.where} | {k: str(v) for k, v in fixed.items()} | free
    spans = ", ".join(f"{model.free[k].key} ±{fitted.half_width[k]:.2g}" for k in numbers)
    inside = ", ".join(f"{key}: {value}" for key, value in values.items())
    return f"- {{{inside}}}  # [gap] {remark}{'; 95%: ' + spans if spans else ''}"


def with_step_lines(text: str, coarse: Sequence[CoarseStep]) -> str:
    """The text with an effect line for every reading whose steps the data show."""
    for item in coarse:
        values = f"effect: sensor_quantization, where: {item.where}, step: {written(item.step)} {item.unit}"
        remark = "longreach gap find, confirmed: every value of every log lies on these steps"
        text = with_effect_line(text, f"- {{{values}}}  # [gap] {remark}")
    return text


def written(value: float) -> str:
    """Six digits, always with a decimal point or exponent that YAML and pint read as a number."""
    return f"{float(value):.6g}"


def with_effect_line(text: str, line: str) -> str:
    """The line after the last entry of plant.effects; the list is made when there is none."""
    tree = parse(text, "rig.yaml")
    plant = entry_in(tree.root, "plant")
    assert plant is not None
    effects = entry_in(plant[1], "effects")
    rows = _rows(text)
    items = effects[1].value if effects else []
    if items and not effects[1].flow_style:  # type: ignore[index, union-attr]
        last = items[-1]
        indent, after = last.start_mark.column - 2, last.end_mark.line + (0 if last.end_mark.column == 0 else 1)
        rows.insert(after, " " * max(indent, 0) + line + "\n")
        return "".join(rows)
    column = plant[1].start_mark.column
    if effects is not None:
        del rows[effects[0].start_mark.line]
    rows.insert(plant[1].start_mark.line, f"{' ' * column}effects:\n{' ' * (column + 2)}{line}\n")
    return "".join(rows)


def _with_values(text: str, values: Sequence[tuple[Free, float]]) -> str:
    """Constants' new values in the units they were stated in, and the old ones in comments; a key with its default is put in."""
    tree = parse(text, "rig.yaml")
    old = [tree.value(_file_path(free)) for free, _ in values]
    text = apply_overrides(text, [_assignment(free, value, before) for (free, value), before in zip(values, old, strict=True)])
    tree, rows = parse(text, "rig.yaml"), _rows(text)
    for (free, _), before in zip(values, old, strict=True):
        number = tree.mark(_file_path(free))[0] - 1
        row = rows[number].rstrip("\n")
        said = before if before is not None else f"{free.start:g} {free.unit}".strip() + " by default"
        remark = f"[gap] {free.key.rpartition('.')[2]} was {said}"
        rows[number] = row + (f"; {remark}" if "#" in row else f"  # {remark}") + "\n"
    return "".join(rows)


def _assignment(free: Free, value: float, old: object) -> str:
    """`key=value unit`, in the unit of the old value where that has one."""
    unit = written_unit(old) or free.unit
    shown = value if unit == free.unit else from_si(value, free.unit, unit)
    return f"{free.key}={written(shown)} {unit}".strip()


def _rows(text: str) -> list[str]:
    """Lines that all end: what is put behind a last line without an end would stand in its comment."""
    return (text if text.endswith("\n") else f"{text}\n").splitlines(keepends=True)


def _file_path(free: Free) -> tuple[str | int, ...]:
    """Path in the file: names of sensors hold dots themselves."""
    if free.path[0] == "sensors":
        return ("plant", "sensors", str(free.path[1]), free.key.rpartition(".")[2])
    words = free.key.split(".")
    return tuple(int(word) if word.isdigit() else word for word in words)
