"""The process that talks to slow devices: one blocking client a device, each in its own thread, latest samples to shared memory.

A device that does not answer makes its samples old, which the interlocks see; nothing here can make the loop wait. Asked to end, it
serves on until the loop has stopped: samples that grow old would turn a controlled stop into a fault.
python -m daemon.processes.io_process < SPEC
"""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Sequence

from config.schema.rig import Rig
from daemon.ipc.mailbox import Mailbox
from daemon.ipc.slow_samples import post_samples, slow_channels
from daemon.loop.device_bank import CreateDriver
from daemon.processes.channels import ChildSpec
from daemon.processes.children import leave_terminal_to_supervisor, signal_on_parent_death
from drivers import registry
from drivers.contract import Driver, Quality, Sample

FASTEST_POLL_S = 0.01
POLL_S = 0.05
RETRY_S = 1.0  # after a device failed


class SlowDevice:
    """Polls one device four times within the shortest `max_age` of its signals, and opens it again after a failure.

    `failures`: polls without an answer for every channel, and failed openings.
    """

    def __init__(self, name: str, rig: Rig, mailbox: Mailbox, create: CreateDriver = registry.create) -> None:
        self.name = name
        self.polls = self.failures = 0
        self._rig, self._mailbox, self._create = rig, mailbox, create
        self._channels = slow_channels(rig, name)
        self._latest: Sequence[Sample] = [Sample() for _ in self._channels]
        ages = [signal.max_age_s for signal in rig.signals.values() if signal.device == name]
        self._period_s = max(FASTEST_POLL_S, 0.25 * min(ages, default=1.0))

    def run(self, ended: threading.Event) -> None:
        """Until `ended` is set."""
        while not ended.is_set():
            try:
                self._poll(self._create(self.name, self._rig.devices[self.name], self._rig, False), ended)
            except (Exception, SystemExit) as error:  # whatever a driver raises; the loop sees it by the age of the samples
                self.failures += 1
                self._post()
                print(f"longreachd: slow device {self.name}: {error}; trying again in {RETRY_S:g} s", file=sys.stderr, flush=True)
                ended.wait(RETRY_S)

    def _poll(self, driver: Driver, ended: threading.Event) -> None:
        try:
            driver.open()
            driver.configure()
            driver.activate()
            while not ended.is_set():
                started = time.monotonic()
                self.polls += 1
                by_channel = dict(zip(driver.inputs, driver.read(time.monotonic_ns()), strict=True))
                self._latest = [by_channel[channel] for channel in self._channels]
                self.failures += any(sample.quality == Quality.BAD for sample in self._latest)
                self._post()
                ended.wait(max(0.0, started + self._period_s - time.monotonic()))
        finally:
            driver.close()

    def _post(self) -> None:
        post_samples(self._mailbox, self._latest, (float(self.polls), float(self.failures)), time.monotonic_ns())


def main() -> int:
    """Exit status 0 once the loop has stopped."""
    spec = ChildSpec.from_bytes(sys.stdin.buffer.read())
    rig, channels = spec.rig(), spec.channels()
    asked, ended = threading.Event(), threading.Event()
    signal.signal(signal.SIGTERM, lambda number, frame: asked.set())
    leave_terminal_to_supervisor()
    signal_on_parent_death(spec.parent_pid)
    devices = [SlowDevice(name, rig, mailbox) for name, mailbox in channels.slow.items()]
    threads = [threading.Thread(target=device.run, args=(ended,), daemon=True) for device in devices]
    for thread in threads:
        thread.start()
    asked.wait()
    while not channels.loop_is_silent():
        time.sleep(POLL_S)
    ended.set()
    for thread in threads:
        thread.join(timeout=1.0)  # a client may hang in its own time-out
    return 0


if __name__ == "__main__":
    sys.exit(main())
