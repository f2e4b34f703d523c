"""What a view gets that takes nothing for a while."""

from __future__ import annotations

import asyncio

import pytest

from daemon.live.source.pending import EVENTS_KEPT, SAMPLES_KEPT, Pending


def taken(pending: Pending) -> dict[str, object]:
    async def take() -> dict[str, object]:
        async with asyncio.timeout(1.0):
            return await pending.take()

    return asyncio.run(take())


def test_a_stalled_view_keeps_the_newest_samples_and_the_last_word_of_everything_else() -> None:
    pending = Pending()
    for number in range(3 * SAMPLES_KEPT):
        pending.put({"samples": [[float(number)]], "status": {"cycle": number}})
    content = taken(pending)
    assert content["status"] == {"cycle": 3 * SAMPLES_KEPT - 1}
    assert content["samples"] == [[float(number)] for number in range(2 * SAMPLES_KEPT, 3 * SAMPLES_KEPT)]


def test_no_event_is_lost_that_the_daemon_still_has() -> None:
    pending = Pending()
    for number in range(EVENTS_KEPT):
        pending.put({"events": [{"n": number}]})
    assert taken(pending) == {"events": [{"n": number} for number in range(EVENTS_KEPT)]}


def test_what_was_taken_does_not_come_again() -> None:
    pending = Pending()
    pending.put({"status": {}, "samples": [[1.0]]})
    assert set(taken(pending)) == {"status", "samples"}
    pending.put({"samples": [[2.0]]})
    assert taken(pending) == {"samples": [[2.0]]}


def test_samples_of_before_a_restart_do_not_go_with_those_after() -> None:
    pending = Pending()
    pending.put({"samples": [[1.0]], "events": [{"n": 7}]})
    pending.put({"rig": {"name": "other"}})
    pending.put({"samples": [[2.0]]})
    assert taken(pending) == {"rig": {"name": "other"}, "samples": [[2.0]]}


def test_nothing_there_is_waited_for() -> None:
    with pytest.raises(TimeoutError):
        taken(Pending())
