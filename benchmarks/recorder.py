"""Our recorder beside the plain mcap writer and the Foxglove SDK's: cost and size of a cycle, longest call, loss at SIGKILL; and what the
loop pays to hand a cycle's record over.

    python -m benchmarks.recorder [--turns 5] [--json]

All write the same cycles, those of the paper's line in lockstep. Ours puts them on the disk every 100 cycles, as the recorder process
does every 100 ms; the others write whenever their chunk is full, as they come. Loss: the process kills itself after cycle 5050, and
another process counts what can be read. Handing over: packed and put into the ring, the quickest of many short rows of cycles; in the
daemon, with what else the loop does in between, `benchmarks.loop.soak` measures it. The recorder process then gets a row a millisecond.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any

from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap.writer import Writer

import longreach
from benchmarks.loop.held_daemon import cpu_s
from config.loading.load import load_rig
from daemon.cycle.log_stream import LogStream
from daemon.processes.channels import Channels, ChildSpec
from daemon.processes.children import Child
from daemon.processes.recorder_process import SYNC_S
from recording.files.session import Session
from recording.files.writer import CYCLE_TOPIC, LogWriter
from recording.format.layout import CycleLayout

SYNC_EVERY = 100
KILLED_AFTER = 5050
WRITERS = ("longreach", "mcap, plain", "foxglove-sdk")

HANDED_OVER = 5000  # cycles, one a millisecond
BURSTS, BURST = 50, 100
WANTED_US = 5.0
HANDING_OVER = "handing over"

Write = Callable[[int, bytes], None]
Close = Callable[[], None]


@dataclass(frozen=True, slots=True)
class Cost:
    """Of writing every cycle once."""

    processor_us: float
    bytes: float
    longest_ms: float


def ours(path: Path, layout: CycleLayout) -> tuple[Write, Close]:
    writer = LogWriter(path, layout, {}, {})

    def write(t_ns: int, data: bytes) -> None:
        writer.cycle(t_ns, data)
        if writer.cycles % SYNC_EVERY == 0:
            writer.sync()

    return write, lambda: writer.close({})


def plain(path: Path, layout: CycleLayout) -> tuple[Write, Close]:
    stream = path.open("wb")
    writer = Writer(stream)
    writer.start(profile="ros2")
    schema = writer.register_schema(layout.schema_name, "ros2msg", layout.schema_text.encode())
    channel = writer.register_channel(CYCLE_TOPIC, "cdr", schema)

    def close() -> None:
        writer.finish()
        stream.close()

    return lambda t_ns, data: writer.add_message(channel, t_ns, data, t_ns), close


def foxglove_sdk(path: Path, layout: CycleLayout) -> tuple[Write, Close]:
    from foxglove import Channel, Schema, open_mcap

    writer = open_mcap(str(path))
    schema = Schema(name=layout.schema_name, encoding="ros2msg", data=layout.schema_text.encode())
    channel = Channel(CYCLE_TOPIC, schema=schema, message_encoding="cdr")
    return lambda t_ns, data: channel.log(data, log_time=t_ns), writer.close


MAKERS = dict(zip(WRITERS, (ours, plain, foxglove_sdk), strict=True))


def cost(name: str, source: Path, path: Path) -> Cost:
    cycles = _cycles(source)
    write, close = MAKERS[name](path, _layout())
    longest, began = 0.0, time.process_time()
    for t_ns, data in cycles:
        before = time.perf_counter()
        write(t_ns, data)
        longest = max(longest, time.perf_counter() - before)
    close()
    spent = time.process_time() - began
    return Cost(1e6 * spent / len(cycles), path.stat().st_size / len(cycles), 1e3 * longest)


def killed(name: str, source: Path, path: Path) -> None:
    write, _ = MAKERS[name](path, _layout())
    for t_ns, data in _cycles(source)[:KILLED_AFTER]:
        write(t_ns, data)
    os.kill(os.getpid(), signal.SIGKILL)


def readable(path: Path) -> int:
    """Cycles that another program finds in a file that was cut."""
    count = 0
    with path.open("rb") as stream:
        try:
            for _, channel, _ in NonSeekingReader(stream).iter_messages(log_time_order=False):
                count += channel.topic == CYCLE_TOPIC
        except (McapError, EOFError, ValueError):
            pass
    return count


def handed_over(source: Path, folder: Path) -> dict[str, float]:
    """Of one cycle in us: what the loop takes to pack its record and put it into the ring, and processor time of the recorder process."""
    loaded, layout = load_rig("ornl_testbed"), _layout()
    channels = Channels.create(loaded.rig)
    recorder = Child("recorder", ChildSpec.of(loaded.rig, Session.of(loaded, folder, {"clock": "wall"}), os.getpid(), channels), {}, ())
    while not channels.recorder_health.sequence and not recorder.ended():
        time.sleep(0.01)
    log, rows = (
        LogStream(layout, channels.records, channels.events),
        [list(layout.unpack(data)) for _, data in _cycles(source)[:HANDED_OVER]],
    )
    log.open({}, {"span": "armed"})
    loop_us = min(_burst(log, rows[:BURST]) for _ in range(BURSTS))
    time.sleep(2 * SYNC_S)
    before = cpu_s(recorder.pid)
    for row in rows:
        log.cycle(row)
        time.sleep(1e-3)
    time.sleep(2 * SYNC_S)
    recorder_us = 1e6 * (cpu_s(recorder.pid) - before) / len(rows)
    log.close({})
    log.end()
    return {"loop_us": loop_us, "recorder_us": recorder_us}


def _burst(log: LogStream, rows: Sequence[list[float]]) -> float:
    """All at once; us a row."""
    before = time.perf_counter()
    for row in rows:
        log.cycle(row)
    return 1e6 * (time.perf_counter() - before) / len(rows)


def _layout() -> CycleLayout:
    return CycleLayout.of_rig(load_rig("ornl_testbed").rig)


def _cycles(source: Path) -> list[tuple[int, bytes]]:
    with source.open("rb") as stream:
        return [(message.log_time, message.data) for _, _, message in make_reader(stream).iter_messages(topics=[CYCLE_TOPIC])]


def _child(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", "benchmarks.recorder", *words], capture_output=True, text=True, check=False)


def compare(turns: int) -> dict[str, dict[str, Any]]:
    """Writers take turns; medians over the turns, the longest call of all."""
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "line.mcap"
        longreach.simulate("ornl_testbed", "paper_line", out=str(source))
        costs: dict[str, list[Cost]] = {name: [] for name in WRITERS}
        for turn in range(turns):
            for name in WRITERS:
                done = _child("--one", name, str(source), str(Path(folder) / f"{turn}-{WRITERS.index(name)}.mcap"))
                costs[name].append(Cost(**json.loads(done.stdout)))
        found = {name: _row(name, each, source, Path(folder)) for name, each in costs.items()}
        return found | {HANDING_OVER: json.loads(_child("--handed-over", str(source), folder).stdout)}


def _row(name: str, costs: Sequence[Cost], source: Path, folder: Path) -> dict[str, Any]:
    path = folder / f"killed-{WRITERS.index(name)}.mcap"
    _child("--kill", name, str(source), str(path))
    return {
        "processor_us": median(each.processor_us for each in costs),
        "bytes": costs[0].bytes,
        "longest_ms": max(each.longest_ms for each in costs),
        "lost": KILLED_AFTER - (readable(path) if path.exists() else 0),
    }


def main(words: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--turns", type=int, default=5, metavar="N", help="times each writer writes it all (default 5)")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--one", nargs=3, help=argparse.SUPPRESS)
    parser.add_argument("--kill", nargs=3, help=argparse.SUPPRESS)
    parser.add_argument("--handed-over", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args(words)
    if arguments.one:
        print(json.dumps(asdict(cost(arguments.one[0], *map(Path, arguments.one[1:])))))
        return
    if arguments.kill:
        killed(arguments.kill[0], *map(Path, arguments.kill[1:]))
    if arguments.handed_over:
        print(json.dumps(handed_over(*map(Path, arguments.handed_over))))
        return
    rows = compare(arguments.turns)
    if arguments.json:
        print(json.dumps(rows))
        return
    print(f"{'of one cycle':16}{'processor, us':>15}{'bytes':>9}{'longest call, ms':>18}{f'lost of {KILLED_AFTER} at SIGKILL':>26}")
    handing = rows.pop(HANDING_OVER)
    for name, row in rows.items():
        print(f"{name:16}{row['processor_us']:15.1f}{row['bytes']:9.0f}{row['longest_ms']:18.1f}{row['lost']:26}")
    print(f"handing a record over: {handing['loop_us']:.1f} us of the loop (wanted: {WANTED_US:g})")
    print(f"the recorder process, a cycle a millisecond: {handing['recorder_us']:.1f} us of processor each")


if __name__ == "__main__":
    main()
