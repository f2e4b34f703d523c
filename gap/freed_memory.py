"""Freed memory is kept for the next arrays of a search, of whatever thread, and whatever the process was started with.

Dask starts its workers with MALLOC_TRIM_THRESHOLD_=65536, so that they give memory back early (its nanny's pre-spawn environment). With
glibc every array over 128 KiB is then mapped and given back on its own: a search took 439 s of processor time instead of 260, 178 s of
them in the kernel for 61 million page faults.

And glibc gives every thread memory of its own (an arena), in which the others' arrays find no room: the same search needed 2.2 to 2.4 GiB
with an arena a thread, 1.9 with one for all.
"""

from __future__ import annotations

import ctypes

_TRIM_THRESHOLD, _MMAP_THRESHOLD, _ARENA_MAX = -1, -3, -8  # of `man 3 mallopt`
_LIBRARY = ctypes.CDLL(None)
_LARGEST = 32 << 20  # the most that glibc takes for the second
_ONE_FOR_ALL = 1
_NEVER = 2**31 - 1


def keep_freed_memory() -> None:
    """For this process from now on; does nothing where the C library has no mallopt."""
    mallopt = getattr(_LIBRARY, "mallopt", None)
    if mallopt is not None:
        mallopt(_MMAP_THRESHOLD, _LARGEST)
        mallopt(_TRIM_THRESHOLD, _NEVER)
        mallopt(_ARENA_MAX, _ONE_FOR_ALL)


def give_back_freed_memory() -> None:
    """All that is not used now: a stage of a search leaves holes between what it keeps, which the next one does not fit into."""
    trim = getattr(_LIBRARY, "malloc_trim", None)
    if trim is not None:
        trim(0)
