"""The list of named checks that `arm` and `why` show, one line each: value, limit, unit, source, age.

Under a failed one: what to do, and the page that explains it.
"""

from __future__ import annotations

from typing import Any

from config.readable import number
from daemon.cli.shown.terminal import coloured
from daemon.server.stated_values import Units, as_stated

_NAME_WIDTH = 30
_ORDER = {False: 0, "warning": 1, True: 2, None: 3}
_MARKS = {False: ("NO ", "red"), "warning": ("!! ", "yellow"), True: ("ok ", "green"), None: ("?  ", "yellow")}


def checks_lines(checks: list[dict[str, Any]], units: Units | None = None) -> list[str]:
    """Failed checks first, then warnings; a passed check keeps its numbers visible because "why not" often is "nearly not".

    `ok` is None for what nobody knows any more (a moment of a log).
    """
    lines = []
    for check in sorted(checks, key=lambda each: _ORDER[standing(each)]):
        stands = standing(check)
        lines.append(f"{coloured(*_MARKS[stands])} {check['name']:<{_NAME_WIDTH}} {_numbers(as_stated(check, units or {}))}")
        if stands in (False, "warning"):
            lines += [f"    {check[line]}" for line in ("next_step", "page") if check.get(line)]
    return lines


def standing(check: dict[str, Any]) -> bool | str | None:
    """False: failed; "warning"; True: passed; None: nobody knows any more."""
    return "warning" if check["ok"] and check.get("severity") == "warning" else check["ok"]


def _numbers(check: dict[str, Any]) -> str:
    value = check.get("value")
    text = number(value) + (f" {check['unit']}" if check.get("unit") and value is not None else "")
    if check.get("limit"):
        text += f"  (limit {check['limit']})"
    age = check.get("age_s")
    age_text = f", {age * 1e3:.0f} ms old" if isinstance(age, (int, float)) else ""
    return f"{text}  from {check.get('source', '?')}{age_text}"
