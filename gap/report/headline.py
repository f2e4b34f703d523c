"""What a reader wants first, in the units of the rig file: the names with their values, the gap before and after, what is held wrongly."""

from __future__ import annotations

from typing import Any

from config.readable import number, probability
from gap.fitting.nuisance import HONEST
from gap.outcome.file_units import FileUnits
from gap.outcome.held_constants import FINISHED
from gap.outcome.stated_zeros import ALONE

_BAR = 30  # characters of a bar in a terminal


def values(item: dict[str, Any], units: FileUnits) -> str:
    """`friction 74.5 N (68.1 to 81)`, of a finding."""
    return "; ".join(f"{key} {size}" for key, size in ((k, _size(item, k, p, units)) for k, p in item["parameters"].items()))


def blind_values(item: dict[str, Any], units: FileUnits) -> str:
    """The same by the fit logs alone, which predicted the hold-out blind; empty where the values are theirs anyway."""
    known = {key: p["fit_logs"] | {"unit": p["unit"]} for key, p in item["parameters"].items() if "fit_logs" in p}
    return values(item | {"parameters": known}, units)


def _size(item: dict[str, Any], key: str, parameter: dict[str, Any], units: FileUnits) -> str:
    shown = units.channel(item["where"], parameter["unit"])
    low, high = parameter["ci95"]
    return shown.text(parameter["value"]) + (f" ({shown.span((low, high))})" if low != high else "")


def grade(item: dict[str, Any], units: FileUnits) -> str:
    word = "confirmed" if item["confirmed"] else "tentative"
    word += f", probability {probability(item['probability'])}" if "probability" in item else ""
    if "stated" not in item:
        return word
    (changed,) = item["parameters"].values()
    return f"{word}, the file says {units.channel(item['where'], changed['unit']).text(item['stated'])}"


def lead_line(item: dict[str, Any], units: FileUnits) -> str:
    """What helped under `unknown`, which the improved rig file does not have."""
    alike = f" (or {look_alikes(item)})" if item["look_alikes"] else ""
    return f"  not in the file: {item['effect']} at {item['where']}{alike}, {values(item, units)}: helps, but leaves too much to be named"


def look_alikes(item: dict[str, Any]) -> str:
    return ", ".join(f"{x['effect']} at {x['where']}" for x in item["look_alikes"])


def gap_line(content: dict[str, Any]) -> str:
    gap = content["gap"]
    costs = (gap["holdout_before"], gap["holdout_refit"], gap["holdout_after"])
    before, refit, after = (number(float(cost)) for cost in costs)
    line = f"hold-out: {before} → {refit} (constants) → {after} noise floors (1: nothing but noise is left)"
    if "holdout_all_logs" not in gap:
        return line
    return f"{line}; {number(float(gap['holdout_all_logs']))} with constants fitted to all logs, as written"


def pulled_lines(content: dict[str, Any], units: FileUnits) -> list[str]:
    """Constants that the logs want elsewhere than an honest prior is, furthest first. Forces, areas and masses share a scale that logs
    hardly see: a name's size is as right as these numbers."""
    ranked = sorted(content["parameters"].items(), key=lambda item: -pull(item[1]))
    return [_pulled(key, c, units) for key, c in ranked if c["alarm"] or pull(c) > HONEST]


def pull(constant: dict[str, Any]) -> float:
    """How far the written value is from the rig file's, in prior standard deviations."""
    return float(abs(constant["value"] - constant["prior"]["value"]) / constant["prior"]["sd"])


def _pulled(key: str, constant: dict[str, Any], units: FileUnits) -> str:
    shown, prior = units.constant(key, constant["unit"]), constant["prior"]
    tag = f"[{prior['tag']}]" if prior["tag"] else "no tag"
    alarm = "alarm: " if constant["alarm"] else ""
    values = f"{shown.text(prior['value'])} in the rig file ({tag}), {shown.text(constant['value'])} now"
    return f"{alarm}the logs pull {key}: {values}, {pull(constant):.1f} prior standard deviations away. Check that number"


def zero_lines(content: dict[str, Any], units: FileUnits) -> list[str]:
    """What the file states as 0 and the logs want elsewhere: to be read before any name."""
    return [_zero(item, units) for item in content["held"] if item["beside"] != FINISHED]


def _zero(item: dict[str, Any], units: FileUnits) -> str:
    by = "before any name" if item["beside"] == ALONE else f"as {item['beside']}"
    check = "Measure it, or set it with the tag [A], and search again" if item["beside"] == ALONE else "Check that number"
    return f"{item['constant']} is 0 in the rig file (line {item['line']}); {by} the logs want {_where_wanted(item, units)}. {check}"


def held_lines(content: dict[str, Any], units: FileUnits) -> list[str]:
    return [held_line(item, units) for item in content["held"] if item["beside"] == FINISHED]


def held_line(item: dict[str, Any], units: FileUnits) -> str:
    """A constant that no fit may move, and where the logs want it."""
    because = "held by [fixed]" if item["because"] == "fixed" else "0 in the rig file"
    return f"the logs want {item['constant']}, {because}, at {_where_wanted(item, units)}"


def _where_wanted(item: dict[str, Any], units: FileUnits) -> str:
    wanted = item["wanted"]
    shown = units.constant(item["constant"], wanted["unit"])
    span = f"{shown.text(wanted['value'])} ({shown.span(wanted['ci95'])})"
    gain = f"hold-out {number(float(item['holdout_before']))} → {number(float(item['holdout_after']))} noise floors"
    return f"{span}: {gain}"


def bars(content: dict[str, Any], units: FileUnits) -> list[str]:
    """The error of each channel before and after, as bars in a terminal; a channel's longer one is full."""
    channels = content["gap"]["channels"]
    width = max(map(len, channels), default=0)
    lines = []
    for name, c in channels.items():
        shown, most = units.channel(name, c["unit"]), max(c["before"], c["after"], 1e-300)
        for word, size in (("before", c["before"]), ("after", c["after"])):
            filled = round(_BAR * size / most)
            text = f"{number(float(shown.factor * size))} {shown.unit}".rstrip()
            lines.append(f"  {name if word == 'before' else '':{width}}  {word:6} {'█' * filled:{_BAR}} {text}")
    return lines
