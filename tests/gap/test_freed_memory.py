"""Arrays that come and go cost no page faults, also where a process was started as Dask starts its workers."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

FAULTS = """
import resource
import threading
import numpy as np
from gap.freed_memory import keep_freed_memory
if {keep}:
    keep_freed_memory()
def come_and_go():
    kept = [np.ones(1 << 17) for _ in range(100)]  # 1 MiB each
    for _ in range(100):
        np.ones(1 << 17)
def elsewhere():
    thread = threading.Thread(target=come_and_go)
    thread.start()
    thread.join()
{first}()
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
{then}()
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""
ALLOCATED = 200 << 20  # of bytes, by either

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="glibc's allocator")


def faults(keep: bool, first: str, then: str) -> float:
    """Page faults of the second, as a share of the pages that it asks for."""
    environment = {**os.environ, "MALLOC_TRIM_THRESHOLD_": "65536"}
    script = FAULTS.format(keep=keep, first=first, then=then)
    found = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    return int(found.stdout) / (ALLOCATED / os.sysconf("SC_PAGE_SIZE"))


def test_arrays_take_the_memory_that_others_have_freed() -> None:
    assert faults(False, "come_and_go", "come_and_go") > 0.5
    assert faults(True, "come_and_go", "come_and_go") < 0.01


def test_arrays_of_one_thread_take_what_another_has_freed() -> None:
    assert faults(False, "come_and_go", "elsewhere") > 0.5
    assert faults(True, "come_and_go", "elsewhere") < 0.01
