"""What makes a computer late, as far as the system tells: each with what to do about it. Reads /proc and /sys; "unknown" is no cause."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from daemon.host.host_facts import host

_CPU = "sys/devices/system/cpu"
_DEEP_US = 10  # exit latency from which an idle state costs a 1 kHz loop something
_SLOW_USB_MS = 1
_ARPHRD_CAN = "280"  # of a network interface (linux/if_arp.h)
_LONG_QUEUE = 16  # frames: 2 ms of a bus of 1 Mbit/s
_IN_ORDER = (6, 6)  # kernel from which gs_usb keeps frames in their order (Klipper's documentation of CAN adapters)
_PARENT, _PRIORITY, _POLICY = 1, 37, 38  # of the fields behind a process's name in /proc/PID/stat
_KTHREADD = 2  # the kernel's threads are its children
_SHOWN = 4  # real-time programs


@dataclass(frozen=True, slots=True)
class Cause:
    """`name`: what was looked at; `value`: what was found; `next_step`: what to do, empty where nothing is wrong."""

    name: str
    value: str
    next_step: str = ""


def causes(root: Path = Path("/"), stolen: float = 0.0) -> list[Cause]:
    """Everything that was looked at. `root`: where proc and sys stand; `stolen`: share of the time that the hypervisor took meanwhile."""
    looked_at = [*_kernel(), _governor(root), *_real_time_limit(root), _real_time_neighbours(root), *_idle_states(root), _siblings(root)]
    return [*looked_at, _hypervisor(root, stolen), *_usb_serial(root), *_can(root)]


def stolen_ticks(root: Path = Path("/")) -> tuple[int, int]:
    """Ticks of all processors so far: taken by the hypervisor, and all of them (`man 5 proc`, /proc/stat)."""
    numbers = [int(word) for word in _text(root / "proc/stat").partition("\n")[0].split()[1:9]]
    return (numbers[7], sum(numbers)) if len(numbers) == 8 else (0, 1)


def _kernel() -> Iterator[Cause]:
    facts = host()
    rt = "" if facts["host_preempt_rt"] == "yes" else "A PREEMPT_RT kernel bounds the worst wake-up (Debian: linux-image-rt-amd64)."
    yield Cause("kernel", f"{facts['host_kernel'].split()[1]}, PREEMPT_RT: {facts['host_preempt_rt']}", rt)
    isolated = facts["host_isolated_cpus"]
    advice = "" if isolated not in ("none", "unknown") else "Keep other work off one processor: boot with isolcpus=N, then loop.cpu: N."
    yield Cause("isolated processors", isolated, advice)


def _governor(root: Path) -> Cause:
    found = sorted({_text(path) for path in (root / _CPU).glob("cpu[0-9]*/cpufreq/scaling_governor")} - {""})
    advice = "cpupower frequency-set -g performance" if found and found != ["performance"] else ""
    return Cause("governor", ", ".join(found) or "unknown (the host sets the clock)", advice)


def _real_time_limit(root: Path) -> Iterator[Cause]:
    """What real-time work may take of a processor (kernel documentation, scheduler/sched-rt-group): the rest is one pause a second."""
    runtime, period = (_text(root / f"proc/sys/kernel/sched_rt_{name}_us") for name in ("runtime", "period"))
    if not (runtime and period):
        return
    left_ms = (int(period) - int(runtime)) // 1000
    if int(runtime) < 0 or left_ms <= 0:
        yield Cause("real-time limit", "none")
        return
    advice = f"Pauses of {left_ms} ms? Real-time work fills a processor: give loop.cpu to the loop alone (isolcpus=N), a twin another."
    yield Cause("real-time limit", f"{left_ms} ms of every {int(period) // 1000} ms are kept for other work", advice)


def _real_time_neighbours(root: Path) -> Cause:
    """Programs with a real-time priority beside this one (`man 5 proc`, /proc/PID/stat); the kernel's own threads are none."""
    found = sorted(one for path in (root / "proc").glob("[0-9]*/stat") if (one := _real_time_program(path)))
    advice = "While one of them works, a loop of lower priority waits: take it away (chrt -o -p 0 PID), or give loop.cpu to the loop alone."
    return Cause("real-time programs", ", ".join(found[:_SHOWN]) or "none", advice if found else "")


def _real_time_program(stat: Path) -> str:
    """Name, number and priority of a process that has one; empty for others, and for this one and what it started."""
    head, _, tail = _text(stat).rpartition(") ")
    number, _, name = head.partition(" (")
    fields = tail.split()
    if len(fields) <= _POLICY or int(fields[_POLICY]) not in (os.SCHED_FIFO, os.SCHED_RR):
        return ""
    own, kernel = os.getpid() in (int(number), int(fields[_PARENT])), _KTHREADD in (int(number), int(fields[_PARENT]))
    return "" if own or kernel else f"{name} (process {number}, priority {fields[_PRIORITY]})"


def _idle_states(root: Path) -> Iterator[Cause]:
    states = sorted((root / _CPU / "cpu0/cpuidle").glob("state[0-9]*"))
    deepest = [(int(_text(path / "latency") or 0), _text(path / "name")) for path in states]
    slow = [f"{name} {latency} us" for latency, name in deepest if latency >= _DEEP_US]
    if not states:
        yield Cause("idle states", "unknown (the hypervisor's or the firmware's)")
        return
    allowed = os.access(root / "dev/cpu_dma_latency", os.W_OK)
    advice = "" if allowed or not slow else "The service keeps them off; else give this user write access to /dev/cpu_dma_latency."
    yield Cause("idle states", ", ".join(slow) or "none that is slow to leave", advice)


def _siblings(root: Path) -> Cause:
    active = _text(root / _CPU / "smt/active") == "1"
    advice = "Leave the sibling of loop.cpu idle, or switch it off: echo off > /sys/devices/system/cpu/smt/control" if active else ""
    return Cause("hardware threads", "two share a core" if active else "one a core", advice)


def _hypervisor(root: Path, stolen: float) -> Cause:
    virtual = " hypervisor" in _text(root / "proc/cpuinfo")
    value = f"virtual machine, {100 * stolen:.1f} % of the time taken by its host" if virtual else "none"
    return Cause("hypervisor", value, "Its host decides when this machine runs: commission on the rig's own computer." if virtual else "")


def _usb_serial(root: Path) -> Iterator[Cause]:
    for path in sorted((root / "sys/bus/usb-serial/devices").glob("*/latency_timer")):
        wait_ms = int(_text(path) or 0)
        advice = f"echo 1 > /{path.relative_to(root)} (the shipped udev rules do it)" if wait_ms > _SLOW_USB_MS else ""
        yield Cause(f"USB adapter {path.parent.name}", f"holds short answers back for {wait_ms} ms", advice)


def _can(root: Path) -> Iterator[Cause]:
    """CAN interfaces: what waits in a long queue is sent late, and some adapters change the order."""
    for path in sorted((root / "sys/class/net").glob("*")):
        if _text(path / "type") != _ARPHRD_CAN:
            continue
        driver, bus = (_linked(path / "device" / link) for link in ("driver", "subsystem"))
        frames = int(_text(path / "tx_queue_len") or 0)
        advice = []
        if frames > _LONG_QUEUE:
            advice.append(f"Commands grow old in a long queue: ip link set {path.name} txqueuelen 10")
        if driver == "gs_usb" and _kernel_version(root) < _IN_ORDER:
            advice.append("Before Linux 6.6 gs_usb changes the order of frames: take a newer kernel or another adapter.")
        yield Cause(
            f"CAN {path.name}", f"{driver or 'no device'}{f' on {bus}' if bus else ''}, a queue of {frames} frames", " ".join(advice)
        )


def _kernel_version(root: Path) -> tuple[int, ...]:
    """Its first two numbers; newer than any where the system does not say."""
    numbers = _text(root / "proc/sys/kernel/osrelease").split(".")[:2]
    return tuple(map(int, numbers)) if len(numbers) == 2 and all(map(str.isdigit, numbers)) else (sys.maxsize,)


def _linked(path: Path) -> str:
    """Name of what a link of /sys points to; empty without one."""
    return path.resolve().name if path.exists() else ""


def _text(path: Path) -> str:
    try:
        return path.read_text().strip()
    except OSError:
        return ""
