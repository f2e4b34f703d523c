"""Numbers as people read them."""

from __future__ import annotations


def number(value: object, digits: int = 4) -> str:
    """So many significant digits, without an exponent where it can be read without; text as it is."""
    if not isinstance(value, float):
        return "no value" if value is None else str(value)
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < 1e7 else text


def probability(value: float) -> str:
    """Three digits; never 0 or 1, which nobody knows."""
    if value > 0.999:
        return "> 0.999"
    return "< 0.001" if value < 0.001 else f"{value:.3g}"
