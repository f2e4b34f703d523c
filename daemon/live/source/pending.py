"""What one view has not taken yet. A view that stalls loses old samples and keeps the newest of everything else: its share never grows."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import Any

SAMPLES_KEPT = 1000  # 20 s at 50 Hz
EVENTS_KEPT = 5000  # as many as the daemon keeps

Content = dict[str, Any]


class Pending:
    """Filled by the feed, emptied by one view. Keys of a content: those of `Feed`."""

    def __init__(self) -> None:
        self._latest: Content = {}
        self._samples: deque[list[float]] = deque(maxlen=SAMPLES_KEPT)
        self._events: deque[Any] = deque(maxlen=EVENTS_KEPT)
        self._there = asyncio.Event()

    def put(self, content: Content) -> None:
        """Never waits."""
        for key, value in content.items():
            if key == "samples":
                self._samples.extend(value)
            elif key == "events":
                self._events.extend(value)
            else:
                self._forget_before(key)
                self._latest[key] = value
        self._there.set()

    def _forget_before(self, key: str) -> None:
        """Samples and events of another rig or of another start of the daemon do not go with those that follow."""
        if key == "rig":
            self._samples.clear()
            self._events.clear()

    async def take(self) -> Content:
        """Everything there is, as soon as there is something."""
        await self._there.wait()
        self._there.clear()
        content = {**self._latest}
        if self._samples:
            content["samples"] = list(self._samples)
        if self._events:
            content["events"] = list(self._events)
        self._latest.clear()
        self._samples.clear()
        self._events.clear()
        return content
