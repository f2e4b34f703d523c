"""Memory shared by the daemon's processes: anonymous, inherited by descriptor, gone with the last process. Nothing to clean up.

A file in the runtime directory would do the same on tmpfs, but on a disk its write-back would stall the control loop.
"""

from __future__ import annotations

import mmap
import os


class SharedMemory:
    """Zeroed shared memory. Give `descriptor` to a child (subprocess: pass_fds), which attaches to it."""

    def __init__(self, descriptor: int) -> None:
        self.descriptor = descriptor
        self.memory = mmap.mmap(descriptor, 0)
        self.bytes = memoryview(self.memory)
        self.words = self.bytes.cast("q")

    @classmethod
    def create(cls, name: str, size: int) -> SharedMemory:
        """`size` in bytes, rounded up to whole words; `name` shows up in /proc for people who look."""
        descriptor = os.memfd_create(f"longreach-{name}", os.MFD_CLOEXEC)
        os.ftruncate(descriptor, size + -size % 8)
        return cls(descriptor)

    def close(self) -> None:
        self.words.release()
        self.bytes.release()
        self.memory.close()
        os.close(self.descriptor)
