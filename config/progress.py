"""How a long computation says how far it is: one line of text at a time, to whoever called it."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str], None]
