"""`twin RIG.yaml`: the rig's devices, simulated behind real CAN and Modbus connections, in a process of their own."""

from __future__ import annotations

import argparse
import signal
from pathlib import Path

from daemon.cli.options.numbers import SEED, whole

INTERFACES = ("socketcan", "udp_multicast", "virtual")
_EPILOG = """\
The interface and the channel are those of the rig file unless given here. `virtual` stays within this process and is of use in tests
only. `udp_multicast` is refused unless its frames stay on the loopback device. Faults are injected through --control, see
docs/guide/rig/hardware-twin.md.
"""


def options(parser: argparse.ArgumentParser) -> None:
    parser.epilog = _EPILOG
    parser.add_argument("rig", metavar="RIG.yaml", help="a rig file with a plant, or the name of a shipped rig")
    parser.add_argument("--interface", choices=INTERFACES, default="", help="python-can interface")
    parser.add_argument("--channel", default="", help="channel of the interface: can0, 239.74.163.2, ...")
    parser.add_argument("--control", type=Path, metavar="SOCKET", help="Unix socket for fault injection")
    parser.add_argument("--seed", type=SEED, default=0, help="seed of the sensor noise")
    parser.add_argument("--priority", type=int, choices=range(100), default=70, metavar="0..99", help="SCHED_FIFO asked for; 0: none")
    parser.add_argument("--cpu", type=whole(0), metavar="N", help="processor to run on: another than the daemon's loop.cpu")
    parser.add_argument("--quiet", action="store_true", help="no status line")
    parser.set_defaults(run_command=_twin)


def _twin(arguments: argparse.Namespace) -> int:
    from config.loading.load import load_rig
    from sim_backend.twin.process import Twin

    rig = load_rig(arguments.rig).rig
    twin = Twin(rig, arguments.interface, arguments.channel, arguments.control, arguments.seed)
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: twin.stop())
    print(f"twin of {rig.name}: {', '.join(twin.bench.devices)}", flush=True)
    twin.run(None if arguments.quiet else lambda line: print(line, flush=True), arguments.priority, arguments.cpu)
    print("twin: stopped", flush=True)
    return 0
