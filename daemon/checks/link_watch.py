"""What the links to the devices count: once a second into the facts, which `longreach status` shows, and into the recording.

A link is a CAN bus with its devices, or a slow device of the I/O process. Numbers run since the devices were opened. A loss that rises
is also an event for the operator.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from config.schema.rig import Rig
from daemon.cycle.facts import link_facts
from daemon.cycle.log_stream import LogStream
from drivers.canopen.counts import BusState
from drivers.contract import Counts
from recording.format.event import Level

PERIOD_S = 1.0
OVERDUE_SHARE = 0.01  # of the cycles: a shared computer makes single frames late
_LOSSES = ("left_over", "send_failures", "error_frames", "malformed", "failed_polls")
_OVERDUE = ("late", "lost")
_IN_TEXT = ("frames", "foreign", "send_failures", "error_frames", "polls", "failed_polls")


def bus_state(number: float) -> str:
    """In words."""
    return BusState(int(number)).name.lower()


class LinkWatch:
    """All links of one rig. `update` may be called in every cycle, after the outputs are written."""

    def __init__(self, rig: Rig, drivers: Mapping[str, object], indices: Mapping[str, int], log: LogStream) -> None:
        """`indices`: of each fact of link_facts()."""
        self._links = link_facts(rig)
        self._indices = indices
        self._counting = [(name, driver) for name, driver in drivers.items() if isinstance(driver, Counts)]
        self._log = log
        self._most_overdue = OVERDUE_SHARE * rig.loop.rate_Hz * PERIOD_S
        self._before: dict[str, float] = {}
        self._silent: set[str] = set()  # devices that did not say what they count, last time
        self._next_ns = 0

    def count_soon(self) -> None:
        """Count in the next cycle, because a recording begins or ends."""
        self._next_ns = 0

    def update(self, values: list[float], now_ns: int) -> None:
        if now_ns < self._next_ns or not self._links:
            return
        self._next_ns = now_ns + round(1e9 * PERIOD_S)
        self._collect(values)
        for link, facts in self._links.items():
            numbers = {fact: values[self._indices[fact]] for fact in facts}
            text = link_text(link, numbers)
            self._log.note(Level.INFO, "link", text, numbers)
            if trouble := self._trouble(numbers):
                self._log.event(Level.WARNING, "link_trouble", f"{text}; lately {', '.join(trouble)}", numbers)
            self._before |= numbers

    def _collect(self, values: list[float]) -> None:
        """The fast devices' numbers; those of slow ones come with their samples. A device that raises keeps the ones it had."""
        for name, driver in self._counting:
            try:
                link, of_link = driver.link_counts()
                counts_of = ((name, driver.counts()), (link, of_link))
            except Exception as error:  # whatever a driver raises: what it counts moves nothing
                if name not in self._silent:
                    self._log.event(Level.WARNING, "device", f"{name} does not say what it counts: {error}")
                self._silent.add(name)
                continue
            self._silent.discard(name)
            for owner, counts in counts_of:
                for count, number in counts.items():
                    if (index := self._indices.get(f"{owner}.{count}")) is not None:
                        values[index] = number

    def _trouble(self, numbers: Mapping[str, float]) -> list[str]:
        """What was lost since the last count, in words."""
        found = []
        for fact, number in numbers.items():
            count = fact.rpartition(".")[2]
            before = self._before.get(fact, 0.0 if count in _LOSSES else number)
            if count == "state" and number != before:
                found.append(f"{bus_state(before)} → {bus_state(number)}")
            elif (count in _LOSSES and number > before) or (count in _OVERDUE and number - before > self._most_overdue):
                found.append(f"{fact} +{number - before:g}")
        return found


def link_text(link: str, numbers: Mapping[str, float]) -> str:
    """'can0 active: 4000 frames, 0 foreign, 0 send failures, 0 error frames; late: rotary_encoder 2; lost: rotary_valve 1'"""
    state = numbers.get(f"{link}.state")
    shown = [f"{numbers[fact]:.0f} {count.replace('_', ' ')}" for count in _IN_TEXT if (fact := f"{link}.{count}") in numbers]
    head = link if state is None else f"{link} {bus_state(state)}"
    return f"{head}: {', '.join(shown)}" + "".join(_overdue_text(count, numbers) for count in _OVERDUE)


def _overdue_text(count: str, numbers: Mapping[str, float]) -> str:
    devices = [f"{owner} {number:.0f}" for fact, number in numbers.items() if (owner := fact.removesuffix(f".{count}")) != fact and number]
    return f"; {count}: {', '.join(devices)}" if devices else ""


class LinksView:
    """For `status`: link → its line of text and all its numbers by fact."""

    def __init__(self, rig: Rig, indices: Mapping[str, int]) -> None:
        self._links = {link: {fact: indices[fact] for fact in facts} for link, facts in link_facts(rig).items()}

    def status(self, values: Sequence[float]) -> dict[str, Any]:
        shown = {}
        for link, indices in self._links.items():
            numbers = {fact: values[index] for fact, index in indices.items()}
            shown[link] = {"text": link_text(link, numbers), "counts": numbers}
        return shown
