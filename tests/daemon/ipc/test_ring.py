from __future__ import annotations

import subprocess
import sys

from hypothesis import given, settings
from hypothesis import strategies as st

from daemon.ipc.mailbox import Mailbox
from daemon.ipc.ring import Record, Ring
from daemon.ipc.shared_memory import SharedMemory

# Reads until it has seen `count` records; prints a digest of what it saw.
READER = """
import hashlib, os, sys
from daemon.ipc.ring import Ring
from daemon.ipc.shared_memory import SharedMemory
ring = Ring(SharedMemory(int(sys.argv[1]))); digest = hashlib.sha256(); seen = 0
while seen < int(sys.argv[2]):
    record = ring.read()
    if record is None:
        os.sched_yield()
        continue
    digest.update(repr((record.kind, record.stamp_ns, record.data)).encode()); seen += 1
print(digest.hexdigest())
"""


@given(st.lists(st.one_of(st.none(), st.binary(max_size=300)), max_size=200), st.integers(320, 1500))
def test_what_went_in_comes_out_in_order_and_the_rest_is_counted(steps: list[bytes | None], capacity: int) -> None:
    """None reads, anything else is written: against a plain list as the model."""
    ring = Ring.create("test", capacity)
    expected: list[Record] = []
    refused = 0
    for number, data in enumerate(steps):
        if data is None:
            assert ring.read() == (expected.pop(0) if expected else None)
        elif ring.write(number % 7, number, data):
            expected.append(Record(number % 7, number, data))
        else:
            refused += 1
    assert [ring.read() for _ in expected] == expected
    assert ring.read() is None
    assert ring.dropped == refused
    assert ring.backlog_bytes == 0
    ring.shared.close()


@settings(max_examples=8, deadline=None)
@given(st.lists(st.integers(0, 3000), min_size=50, max_size=400), st.integers(8_192, 60_000))
def test_two_processes_lose_nothing_while_there_is_room(sizes: list[int], capacity: int) -> None:
    import hashlib
    import os

    ring = Ring.create("test", capacity)
    command = [sys.executable, "-c", READER, str(ring.shared.descriptor), str(len(sizes))]
    digest = hashlib.sha256()
    with subprocess.Popen(command, stdout=subprocess.PIPE, pass_fds=(ring.shared.descriptor,), text=True) as reader:
        for number, size in enumerate(sizes):
            data = bytes([number & 255]) * size
            while not ring.write(number % 5, number, data):
                os.sched_yield()
            digest.update(repr((number % 5, number, data)).encode())
        seen, _ = reader.communicate(timeout=60)
    assert seen.strip() == digest.hexdigest()
    ring.shared.close()


def test_a_full_ring_drops_counts_and_goes_on() -> None:
    ring = Ring.create("test", 1024)
    written = sum(ring.write(1, number, bytes(100)) for number in range(20))
    assert written == 1024 // 120
    assert ring.dropped == 20 - written
    assert ring.read() == Record(1, 0, bytes(100))
    assert ring.write(2, 99, bytes(100))


def test_a_reader_that_starts_again_goes_on_where_the_old_one_was() -> None:
    ring = Ring.create("test", 1024)
    for number in range(5):
        ring.write(1, number, b"x")
    ring.read()
    other = Ring(SharedMemory(ring.shared.descriptor))
    assert other.read() == Record(1, 1, b"x")


def test_mailbox_holds_the_latest_and_none_before_the_first() -> None:
    box = Mailbox.create("test", 3)
    assert box.get() is None
    for number in range(1, 6):
        box.put(number, [number, 2.0 * number, float("inf")])
        latest = box.get()
        assert latest is not None
        assert (latest.sequence, latest.stamp_ns, latest.values) == (number, number, (number, 2.0 * number, float("inf")))


def test_mailbox_is_never_half_written_for_another_process() -> None:
    """A process puts equal numbers as fast as it can; all values read meanwhile are equal numbers."""
    box = Mailbox.create("test", 40)
    script = (
        "from daemon.ipc.mailbox import Mailbox; from daemon.ipc.shared_memory import SharedMemory; import sys\n"
        "box = Mailbox(SharedMemory(int(sys.argv[1])))\n"
        "for n in range(1, 60_000): box.put(n, [float(n)] * 40)\n"
    )
    with subprocess.Popen([sys.executable, "-c", script, str(box.shared.descriptor)], pass_fds=(box.shared.descriptor,)) as writer:
        last = seen = 0
        while writer.poll() is None:
            latest = box.get()
            if latest is None:
                continue
            assert set(latest.values) == {float(latest.stamp_ns)}
            assert latest.sequence >= last
            last = latest.sequence
            seen += 1
    assert seen > 100
