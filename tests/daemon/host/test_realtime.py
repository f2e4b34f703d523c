"""What the operating system grants is asked in a process of its own, because it cannot be taken back."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

SCRIPT = """
import ctypes, gc, json, os, sys
from config.schema.rig import Loop
from daemon.host.realtime import request_realtime
if len(sys.argv) > 2:  # as a user without privileges: setuid clears the capabilities
    import resource
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0)); resource.setrlimit(resource.RLIMIT_MEMLOCK, (0, 0)); os.setuid(65534)
facts = request_realtime(Loop(**json.loads(sys.argv[1])))
print(json.dumps({"facts": [[f.name, f.granted, f.value, f.next_step] for f in facts], "rows": [f.row() for f in facts],
    "policy": os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK, "cpus": sorted(os.sched_getaffinity(0)), "gc": gc.isenabled(),
    "switch": sys.getswitchinterval(), "frozen": gc.get_freeze_count()}))
"""


def ask(*arguments: str) -> dict[str, object]:
    done = subprocess.run([sys.executable, "-c", SCRIPT, *arguments], capture_output=True, text=True, check=True)
    answer: dict[str, object] = json.loads(done.stdout)
    return answer


def test_the_interpreter_is_calmed_and_the_rest_is_granted_or_explained() -> None:
    answer = ask('{"priority": 10, "cpu": 0}')
    assert answer["gc"] is False
    assert answer["frozen"]
    assert answer["switch"] == pytest.approx(1e-4)
    facts = answer["facts"]
    assert isinstance(facts, list)
    for name, granted, value, next_step in facts:
        assert value, name
        assert granted or next_step, f"{name} was refused without advice"
    scheduler = facts[0]
    assert (answer["policy"] == 1) == scheduler[1], "the fact says what the kernel says (SCHED_FIFO is 1)"


def test_without_privileges_every_refusal_is_a_visible_fact_and_none_is_fatal() -> None:
    answer = ask('{"priority": 80, "cpu": 9999}', *(["drop"] if os.getuid() == 0 else []))
    facts = {name: (granted, next_step) for name, granted, _, next_step in answer["facts"]}  # type: ignore[attr-defined]
    assert facts["processor"][0] is False
    assert "loop.cpu" in facts["processor"][1]
    assert facts["real-time priority"][0] is False
    assert "CAP_SYS_NICE" in facts["real-time priority"][1]
    assert facts["locked memory"][0] is False
    assert facts["idle states"][0] is False
    assert "/dev/cpu_dma_latency" in facts["idle states"][1]
    assert all(row["ok"] for row in answer["rows"])  # type: ignore[attr-defined]
    assert sum(row["severity"] == "warning" for row in answer["rows"]) == 4  # type: ignore[attr-defined]
