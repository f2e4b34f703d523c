"""Fits that do not wait for each other, on the threads of a search.

What one fit does by itself keeps hardly more than one processor busy: a step waits for the one before. So sets that are asked for anyway
are fitted beside each other. Results do not hang on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from gap.evidence.score.hypothesis import Seen

Item = TypeVar("Item")
Done = TypeVar("Done")


def side_by_side(seen: Seen, work: Callable[[Item], Done], items: Iterable[Item]) -> list[Done]:
    """`work` of every item, in their order."""
    with ThreadPoolExecutor(seen.threads) as pool:
        return list(pool.map(work, items))
