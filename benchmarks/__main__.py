"""`make bench`: every short benchmark, one after the other, and a page of what they printed. The long one is `benchmarks.loop.soak`.

python -m benchmarks [--page build/speed.md] [--only kernel recorder]
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from config.whole_file import write_whole
from daemon.host.host_facts import host, software

# What is run, and what it shows.
BENCHMARKS = {
    "kernel.beside": ("The kernel beside C and scipy", ()),
    "kernel": ("The kernel by itself", ()),
    "loop.controller": ("The controller's step", ()),
    "recorder": ("The recorder beside other writers", ()),
    "loop.scale": ("How large a rig fits", ()),
    "kernel.batches": ("Batches of simulations on two threads", ()),
    "loop.jitter": ("The loop's clock beside cyclictest and LinuxCNC", ()),
    "commands": ("Commands", ()),
    "ratios": ("Ratios beside the kept baseline", ()),
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--page", type=Path, default=Path("build/speed.md"), help="where the page goes (default %(default)s)")
    parser.add_argument("--only", nargs="+", choices=tuple(BENCHMARKS), default=tuple(BENCHMARKS), help="these alone")
    arguments = parser.parse_args()
    parts, failed = [_head(arguments.only)], []
    for name in arguments.only:
        title, options = BENCHMARKS[name]
        command = ["python", "-m", f"benchmarks.{name}", *options]
        print(f"== {' '.join(command)}", flush=True)
        done = subprocess.run([sys.executable, *command[1:]], stdout=subprocess.PIPE, text=True, check=False)
        print(done.stdout, flush=True)
        failed += [name] if done.returncode else []
        parts.append(f"## {title}\n\n`{' '.join(command)}`\n\n```text\n{done.stdout.rstrip()}\n```\n")
    write_whole(arguments.page, "\n".join(parts), "page")
    print(f"the page: {arguments.page}" + (f"; failed: {', '.join(failed)}" if failed else ""))
    return 1 if failed else 0


def _head(names: Sequence[str]) -> str:
    """The machine and the version: only lines of one run may be compared."""
    facts, own = host(), software()
    load = os.getloadavg()[0]
    return (
        "# Results: on time and fast\n\n"
        f"`python -m benchmarks --only {' '.join(names)}`,\n{datetime.now(UTC):%Y-%m-%d}, commit {own['software_commit']}.\n"
        f"{facts['host_cpu']}, {facts['host_cpus']} processors, Python {facts['host_python']}, kernel {facts['host_kernel'].split()[1]},\n"
        f"PREEMPT_RT: {facts['host_preempt_rt']}; {load:.1f} processes wanted a processor before it began.\n\n"
        "A shared machine has good and bad minutes: compare only what stands in one table, and the ratios before\nthe rest.\n"
    )


if __name__ == "__main__":
    sys.exit(main())
