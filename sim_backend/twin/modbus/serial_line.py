"""A serial line that is none: two pseudo terminals, joined, so that pymodbus' serial server and a driver each open an end by name.

The driver's end stands where the rig file says (`port`), as a link that goes when the line is closed. A pseudo terminal has no baud rate
and no parity bit: which settings the real line has is not tested by it.
"""

from __future__ import annotations

import os
import pty
import select
import threading
import tty
from pathlib import Path

from config.errors import PlantError

_POLL_S = 0.05
_MOST_BYTES = 512


class SerialLine:
    """`server_port` is the name of the server's end. PlantError when something stands at `port` already, or it can't be made."""

    def __init__(self, port: str) -> None:
        self._link = Path(port)
        if self._link.is_symlink() and not self._link.exists():
            self._link.unlink()  # of a twin that was killed
        self._ends = [pty.openpty() for _ in range(2)]
        for descriptor in (each for pair in self._ends for each in pair):
            tty.setraw(descriptor)
        self.server_port, driver_port = (os.ttyname(slave) for _, slave in self._ends)
        try:
            self._link.symlink_to(driver_port)
        except OSError as error:
            self._close_ends()
            advice = "Write a port of your own for the simulation, for example port: ./serial_line; real ports are left alone."
            raise PlantError("the serial line cannot be simulated there", value=error.strerror, where=port, next_step=advice) from error
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._carry, name="serial line", daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self._link.unlink(missing_ok=True)
        self._close_ends()

    def _carry(self) -> None:
        """Bytes from each end to the other."""
        first, second = (master for master, _ in self._ends)
        other = {first: second, second: first}
        while not self._ended.is_set():
            for end in select.select([first, second], [], [], _POLL_S)[0]:
                os.write(other[end], os.read(end, _MOST_BYTES))

    def _close_ends(self) -> None:
        for descriptor in (each for pair in self._ends for each in pair):
            os.close(descriptor)
