"""How the samples of a slow device get from the I/O process to the loop: one mailbox a device, three numbers a channel, and its counts."""

from __future__ import annotations

from collections.abc import Sequence

from config.schema.rig import Rig
from daemon.cycle.facts import SLOW_COUNTS
from daemon.ipc.mailbox import Mailbox
from drivers.contract import Sample


def slow_channels(rig: Rig, device: str) -> tuple[str, ...]:
    """Channels of a slow device that the rig uses, in the order of its mailbox."""
    return tuple(signal.channel for signal in rig.signals.values() if signal.device == device)


def slow_mailbox(rig: Rig, device: str) -> Mailbox:
    """Raw, stamp in ns and quality of every channel, then SLOW_COUNTS."""
    return Mailbox.create(device, 3 * len(slow_channels(rig, device)) + len(SLOW_COUNTS))


def post_samples(box: Mailbox, samples: Sequence[Sample], counts: Sequence[float], now_ns: int) -> None:
    numbers = [number for sample in samples for number in (sample.raw, float(sample.stamp_ns), float(sample.quality))]
    box.put(now_ns, [*numbers, *counts])


def fetch_samples(box: Mailbox, samples: Sequence[Sample]) -> tuple[float, ...]:
    """Fills the samples with what was posted last; returns the counts, zeros before the first post."""
    latest = box.get()
    if latest is None:
        return (0.0,) * len(SLOW_COUNTS)
    for number, sample in enumerate(samples):
        raw, stamp, quality = latest.values[3 * number : 3 * number + 3]
        sample.raw, sample.stamp_ns, sample.quality = raw, int(stamp), int(quality)
    return latest.values[3 * len(samples) :]
