"""findings.json as design §5 writes it down, by hand, without the code that makes it: every key, its kind, and what may be null."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

VERDICTS = {"no_gap", "parameter_mismatch", "named", "ambiguous", "unknown", "data_problem"}

Check = Callable[[Any, str], list[str]]


def number(value: Any, at: str) -> list[str]:
    return [] if isinstance(value, (int, float)) and not isinstance(value, bool) else [f"{at}: not a number: {value!r}"]


def text(value: Any, at: str) -> list[str]:
    return [] if isinstance(value, str) else [f"{at}: not a text: {value!r}"]


def truth(value: Any, at: str) -> list[str]:
    return [] if isinstance(value, bool) else [f"{at}: not true or false: {value!r}"]


def optional(check: Check) -> Check:
    return lambda value, at: [] if value is None else check(value, at)


def several(check: Check, count: int | None = None) -> Check:
    def all_of(value: Any, at: str) -> list[str]:
        if not isinstance(value, list) or (count is not None and len(value) != count):
            return [f"{at}: not a list{f' of {count}' if count else ''}: {value!r}"]
        return [problem for k, item in enumerate(value) for problem in check(item, f"{at}[{k}]")]

    return all_of


def named(check: Check) -> Check:
    def every(value: Any, at: str) -> list[str]:
        if not isinstance(value, dict):
            return [f"{at}: not an object: {value!r}"]
        return [problem for key, item in value.items() for problem in check(item, f"{at}.{key}")]

    return every


def thing(**keys: Check) -> Check:
    """An object with at least these keys."""

    def checked(value: Any, at: str) -> list[str]:
        if not isinstance(value, dict):
            return [f"{at}: not an object: {value!r}"]
        missing = [f"{at}: no key {key}" for key in keys if key not in value]
        return missing + [p for key, check in keys.items() if key in value for p in check(value[key], f"{at}.{key}")]

    return checked


def share(value: Any, at: str) -> list[str]:
    return number(value, at) or ([] if 0.0 <= value <= 1.0 else [f"{at}: not a share: {value}"])


def verdict(value: Any, at: str) -> list[str]:
    return [] if value in VERDICTS else [f"{at}: no verdict: {value!r}"]


def sha256(value: Any, at: str) -> list[str]:
    good = isinstance(value, str) and len(value) == 64 and set(value) <= set("0123456789abcdef")
    return [] if good else [f"{at}: no SHA-256: {value!r}"]


INTERVAL = several(number, 2)
VALUE = thing(value=number, unit=text, ci95=INTERVAL)
LOOK_ALIKE = thing(effect=text, where=text, holdout_gain=number)
FINDING = thing(
    effect=text,
    where=text,
    confirmed=truth,
    parameters=named(VALUE),
    holdout_gain=number,
    t=number,
    look_alikes=several(LOOK_ALIKE),
    fingerprint=text,
)
CONSTANT = thing(prior=thing(value=number, sd=number), value=number, ci95=INTERVAL, alarm=truth)
GAP = thing(
    unit=lambda value, at: [] if value == "noise floors" else [f"{at}: {value!r}"],
    holdout_before=number,
    holdout_refit=number,
    holdout_after=number,
    channels=named(thing(before=number, after=number, unit=text)),
)
FINDINGS = thing(
    verdict=verdict,
    where=several(thing(channel=text, equation=text, region=text, band_Hz=INTERVAL, share=share)),
    findings=several(FINDING),
    leads=several(FINDING),
    parameters=named(CONSTANT),
    gap=GAP,
    judge=several(thing(over=several(text), ln=number, ci95=INTERVAL)),
    not_seen=several(thing(effect=text, smallest_visible=optional(number), unit=text)),
    next_maneuver=optional(thing(name=text, why=text, expected_t=number, separates=several(text))),
    software=text,
    inputs=several(thing(file=text, sha256=sha256)),
)


def problems(content: Any) -> list[str]:
    """Everything in which a findings file departs from the contract; empty when it keeps it."""
    found = FINDINGS(content, "findings")
    if not found and content["verdict"] == "named" and not content["findings"]:
        found.append("findings: named, but without a name")
    if not found and bool(content["leads"]) > (content["verdict"] == "unknown"):
        found.append("leads: only `unknown` has them")
    return found
