"""The process that writes logs: drains the ring, syncs every 100 ms, reports its health.

    python -m daemon.processes.recorder_process < SPEC

It outlives the others: when the supervisor or the control process dies, it writes what is in the ring, closes the file and ends.
"""

from __future__ import annotations

import json
import signal
import sys
import time

from config.errors import LogError
from daemon.cycle.log_stream import RecordKind
from daemon.ipc.ring import Record
from daemon.processes.channels import Channels, ChildSpec, RecorderHealth
from daemon.processes.children import leave_terminal_to_supervisor, signal_on_parent_death
from daemon.processes.recorder import Recorder

POLL_S = 0.02  # each waking costs as much processor time as writing several rows; the ring holds seconds
SYNC_S = 0.1
AT_ONCE = 100  # records between two looks at the clock


class RecorderProcess:
    """Drains the ring into the recorder, reports health, and closes the file whichever way the loop ends."""

    def __init__(self, channels: Channels, recorder: Recorder) -> None:
        self._channels = channels
        self._recorder = recorder
        self._failed = False
        self._reported_path = ""
        self._stamp_ns = 0
        self._next_sync = 0.0
        self._loop_ended = False
        self.asked_to_end = False

    def on_signal(self, number: int, frame: object) -> None:
        self.asked_to_end = True

    def run(self) -> None:
        """Until the loop has ended, or is silent after this process was asked to end."""
        while not self._loop_ended:
            drained = self._drain()
            if drained and self.asked_to_end and self._channels.loop_is_silent():
                break
            left_s = self._next_sync - time.monotonic()
            if left_s <= 0.0:
                self._sync()
            elif drained:
                time.sleep(min(POLL_S, left_s))
        self._guarded_close()
        self._report()

    def _drain(self) -> bool:
        """Write what the ring holds, but no more than AT_ONCE: True when more is to be waited for."""
        read = self._channels.records.read
        for _ in range(AT_ONCE):
            record = read()
            if record is None:
                return True
            if record.kind == RecordKind.END:
                self._loop_ended = True
                return False
            self._write(record)
        return False

    def _write(self, record: Record) -> None:
        self._stamp_ns = record.stamp_ns
        if self._failed and record.kind != RecordKind.OPEN:
            return
        try:
            self._recorder.handle(record.kind, record.stamp_ns, record.data)
        except (LogError, ValueError) as error:
            self._fail(error)

    def _sync(self) -> None:
        self._next_sync = time.monotonic() + SYNC_S
        try:
            self._recorder.sync()
        except LogError as error:
            self._fail(error)
        self._report()

    def _fail(self, error: Exception) -> None:
        """Report it and go on draining, so that the loop ends with a controlled stop and not with a full ring."""
        self._failed = True
        self._recorder.abandon()
        self._send_report({"error": str(error)})

    def _report(self) -> None:
        path = self._recorder.path
        size = path.stat().st_size if path is not None and path.exists() else 0
        if path is not None and str(path) != self._reported_path:
            self._reported_path = str(path)
            self._send_report({"path": self._reported_path})
        health = RecorderHealth(float(self._failed), float(self._recorder.open), float(size))
        self._channels.recorder_health.put(time.monotonic_ns(), health)

    def _send_report(self, content: dict[str, str]) -> None:
        self._channels.recorder_reports.write(RecordKind.RECORDER, time.monotonic_ns(), json.dumps(content).encode())

    def _guarded_close(self) -> None:
        try:
            self._recorder.close(self._stamp_ns, {"ended_by": "the control process died"})
        except LogError as error:
            self._fail(error)


def main() -> int:
    """Exit status 0; a file that cannot be written is reported to the loop and the supervisor."""
    spec = ChildSpec.from_bytes(sys.stdin.buffer.read())
    process = RecorderProcess(spec.channels(), Recorder(spec.session))
    signal.signal(signal.SIGTERM, process.on_signal)
    leave_terminal_to_supervisor()
    signal_on_parent_death(spec.parent_pid)
    process.run()
    return 0


if __name__ == "__main__":
    sys.exit(main())
