"""`make bench`: every short benchmark, one after the other. `python -m benchmarks.soak` is the long one."""

from __future__ import annotations

from benchmarks import controller, kernel

for benchmark in (kernel, controller):
    print(f"== {benchmark.__name__}", flush=True)
    benchmark.main()
