"""Arrays that come and go cost no page faults, also where a process was started as Dask starts its workers."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

FAULTS = """
import resource
import numpy as np
from gap.freed_memory import keep_freed_memory
if {keep}:
    keep_freed_memory()
for _ in range(200):
    np.ones(1 << 17)  # 1 MiB
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(200):
    np.ones(1 << 17)
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def faults(keep: bool) -> int:
    environment = {**os.environ, "MALLOC_TRIM_THRESHOLD_": "65536"}
    found = subprocess.run([sys.executable, "-c", FAULTS.format(keep=keep)], env=environment, capture_output=True, text=True, check=True)
    return int(found.stdout)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="glibc's allocator")
def test_arrays_take_the_memory_that_others_have_freed() -> None:
    pages = 200 * (1 << 20) // os.sysconf("SC_PAGE_SIZE")
    assert faults(keep=False) > 0.5 * pages
    assert faults(keep=True) < 0.01 * pages
