"""The list of named checks that `arm` and `why` show, one line each: value, limit, unit, source, age; what to do under a failed one."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.text import Text

_NAME_WIDTH = 30
_ORDER = {False: 0, "warning": 1, True: 2, None: 3}
_MARKS = {False: ("NO ", "red bold"), "warning": ("!! ", "yellow"), True: ("ok ", "green"), None: ("?  ", "yellow")}


def console() -> Console:
    return Console(highlight=False, soft_wrap=True)


def checks_lines(checks: list[dict[str, Any]]) -> list[Text]:
    """Failed checks first, then warnings; a passed check keeps its numbers visible because "why not" often is "nearly not".

    `ok` is None for what nobody knows any more (a moment of a log).
    """
    lines = []
    for check in sorted(checks, key=lambda each: _ORDER[_standing(each)]):
        standing = _standing(check)
        lines.append(Text.assemble(_MARKS[standing], f" {check['name']:<{_NAME_WIDTH}} ", _numbers(check)))
        if standing in (False, "warning") and check.get("next_step"):
            lines.append(Text(f"    {check['next_step']}"))
    return lines


def _standing(check: dict[str, Any]) -> bool | str | None:
    return "warning" if check["ok"] and check.get("severity") == "warning" else check["ok"]


def _numbers(check: dict[str, Any]) -> str:
    unit = f" {check['unit']}" if check.get("unit") else ""
    text = f"{number(check.get('value'))}{unit}"
    if check.get("limit"):
        text += f"  (limit {check['limit']})"
    age = check.get("age_s")
    age_text = f", {age * 1e3:.0f} ms old" if isinstance(age, (int, float)) else ""
    return f"{text}  from {check.get('source', '?')}{age_text}"


def number(value: object) -> str:
    """Four significant digits for numbers, text as it is."""
    return f"{value:.4g}" if isinstance(value, float) else "no value" if value is None else str(value)
