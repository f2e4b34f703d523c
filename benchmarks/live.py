"""What watching costs the loop: its lateness with every live view at once beside its lateness without, in turns; and how late plots are.

    python -m benchmarks.live [--pairs 5] [--seconds 20] [--rate 1000] [--json]

Watching: the page in headless Chromium, `top`, `live` with a client that takes everything, `status` and `checks` asked 50 times a second,
a log that is read over and over, a client of the socket and a browser that read nothing of what they asked for. The arm holds. A shared
machine has good and bad minutes, so only what is compared within a pair means anything, and every second pair is watched first. The loop
spins up to its deadline: a cycle is late by part of one look at the clock, and the p99 is that look as long as fewer than one cycle in a
hundred comes later. The share later than a microsecond stands beside it: that is what a busy machine changes first.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from math import nan
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from websockets.sync.client import connect

from config.errors import DaemonError
from config.loading.load import apply_overrides, load_rig
from daemon.server.protocol import VERSION, Client, encode
from recording.files.reader import Log, read_log
from tests.support.daemon.running_daemon import RunningDaemon, arm, until
from tests.support.live.browser import browser
from tests.support.live.page_server import TOKEN, PageServer, page_server
from tests.support.live.terminal import longreach_in_terminal

POLL_S = 0.02
LATER_US = 1.0
SETTLE_S = 2.0
READY_S = 60.0
BEHIND = "return document.getElementById('behind').textContent"
MOST_FAULTS = 5
Span = tuple[int, int]  # first and last cycle
Turns = dict[str, dict[str, float]]  # alone and watched


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=20.0, help="of each turn")
    parser.add_argument("--rate", type=float, default=1000.0, help="of the loop, Hz")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    result = compared(arguments.pairs, arguments.seconds, arguments.rate)
    print(json.dumps(result) if arguments.json else table(result))


def compared(pairs: int, seconds: float, rate_Hz: float) -> dict[str, Any]:
    """Lateness (p50, p99 in us) of every turn, the ratio of the p99 of each pair, and how many ms behind the page's plots were. A pair in
    which the loop faults is run again and counted: a shared machine stands still for longer than the loop allows."""
    turns: list[Turns] = []
    behind_ms: list[float] = []
    faults = 0
    with tempfile.TemporaryDirectory() as folder, RunningDaemon(Path(folder), _rig(Path(folder), rate_Hz)) as daemon:
        daemon.wait_until_ready().close()
        while len(turns) < pairs and faults < MOST_FAULTS:
            try:
                turn, behind = _pair(daemon, Path(folder) / f"{len(turns)}-{faults}", seconds, watched_first=len(turns) % 2 == 1)
            except (AssertionError, DaemonError) as error:
                faults += 1
                print(f"a pair is run again: {str(error).splitlines()[0][:160]}", file=sys.stderr, flush=True)
                continue
            turns.append(turn)
            behind_ms += behind
    return _figures(turns, behind_ms) | {"run_again": faults}


def _pair(daemon: RunningDaemon, folder: Path, seconds: float, watched_first: bool) -> tuple[Turns, list[float]]:
    """A recording of its own: alone and watched. AssertionError or DaemonError when the arm does not hold to its end."""
    behind_ms: list[float] = []
    spans: dict[str, Span] = {}
    with Client(daemon.socket) as client:
        client.call("disarm")
        arm(client)
        for kind in ("watched", "alone") if watched_first else ("alone", "watched"):
            with _watched(daemon, folder) if kind == "watched" else nullcontext() as page:
                time.sleep(SETTLE_S)
                spans[kind] = _span(client, seconds, (lambda page=page: behind_ms.append(_behind_ms(page))) if page else _nothing)
        status = client.call("status")
        assert status["mode"] == "holding", status["fault"]
        client.call("disarm")
    log = daemon.latest_log()
    until(lambda: read_log(log).complete, 30.0)
    return {kind: _late(read_log(log), span) for kind, span in spans.items()}, behind_ms


def _late(log: Log, span: Span) -> dict[str, float]:
    chosen = (log.columns["cycle"] >= span[0]) & (log.columns["cycle"] <= span[1])
    late_us = log.columns["late_us"][chosen]
    p50, p99 = np.quantile(late_us, (0.5, 0.99)).tolist()
    return {"p50_us": p50, "p99_us": p99, "later_share": float(np.mean(late_us > LATER_US))}


def _nothing() -> None:
    """Between the polls of a turn alone."""


def _figures(turns: list[Turns], behind_ms: list[float]) -> dict[str, Any]:
    ratios = [turn["watched"]["p99_us"] / turn["alone"]["p99_us"] for turn in turns]
    quantiles = np.quantile(behind_ms, (0.5, 0.99)).tolist() if behind_ms else [nan, nan]
    return {
        "turns": turns,
        "p99_ratios": ratios,
        "p99_ratio_median": median(ratios) if ratios else nan,
        "p99_more_us_median": median(turn["watched"]["p99_us"] - turn["alone"]["p99_us"] for turn in turns) if turns else nan,
        "behind_ms": dict(zip(("p50", "p99"), quantiles, strict=True)),
        "load_average": list(os.getloadavg()),
        "processors": os.cpu_count(),
    }


def table(result: dict[str, Any]) -> str:
    lines = ["pair  alone p50/p99 us (later)  watched p50/p99 us (later)  ratio of the p99"]
    for number, (turn, ratio) in enumerate(zip(result["turns"], result["p99_ratios"], strict=True), start=1):
        alone, watched = (_shown(turn[kind]) for kind in ("alone", "watched"))
        lines.append(f"{number:4}  {alone:>25}  {watched:>27}  {ratio:16.2f}")
    behind, load = result["behind_ms"], ", ".join(f"{each:.1f}" for each in result["load_average"])
    lines.append(f"median ratio {result['p99_ratio_median']:.2f}, median difference {result['p99_more_us_median']:+.2f} us")
    lines.append(f"plots behind: p50 {behind['p50']:.0f} ms, p99 {behind['p99']:.0f} ms")
    return "\n".join([*lines, f"{result['processors']} processors, load average {load}; {result['run_again']} pairs run again"])


def _shown(late: dict[str, float]) -> str:
    """'0.024/0.049 (0.31 %)': the share of cycles that came more than LATER_US late."""
    return f"{late['p50_us']:.3f}/{late['p99_us']:.3f} ({100 * late['later_share']:.2f} %)"


def _rig(folder: Path, rate_Hz: float) -> str:
    path = folder / "rig.yaml"
    changes = [f"loop.rate={rate_Hz:g} Hz", "loop.overruns.fault_late=1 s", "loop.overruns.stop_after=1000"]
    path.write_text(apply_overrides(load_rig("ornl_testbed").text, changes))
    return str(path)


def _span(client: Client, seconds: float, meanwhile: Callable[[], None] = lambda: None) -> Span:
    first = client.call("status")["cycle"]
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        meanwhile()
        time.sleep(0.2)
    return first, client.call("status")["cycle"]


def _behind_ms(page: Any) -> float:
    """Age of the newest sample in the plots when they were last drawn."""
    return float(page.execute_script(BEHIND).partition(" ")[0])


@contextmanager
def _watched(daemon: RunningDaemon, folder: Path) -> Iterator[Any]:
    """Everything that watches, ready and running; gives the browser."""
    folder.mkdir()
    with ExitStack() as stack:
        served = stack.enter_context(page_server(daemon.socket, folder))
        page = stack.enter_context(browser(folder))
        page.get(served.address)
        until(lambda: page.execute_script(BEHIND), READY_S)
        terminal = stack.enter_context(longreach_in_terminal("--socket", str(daemon.socket), "top"))
        terminal.shows(lambda text: "HOLDING" in text)
        foxglove = stack.enter_context(longreach_in_terminal("--socket", str(daemon.socket), "live", "--port", "0", columns=200))
        address = next(word for word in foxglove.shows(lambda text: "ws://" in text).split() if word.startswith("ws://"))
        stack.enter_context(_stalled(daemon, served))
        work: list[Callable[[threading.Event], None]] = [
            lambda ended: _take_all(address, ended),
            lambda ended: _poll(daemon, ended),
            lambda ended: _download(daemon, ended),
            lambda ended: _read(terminal, ended),
        ]
        stack.enter_context(_meanwhile(work))
        yield page


@contextmanager
def _meanwhile(work: Sequence[Callable[[threading.Event], None]]) -> Iterator[None]:
    """Everything of `work` in a thread of its own, until the event that it is given."""
    ended = threading.Event()
    threads = [threading.Thread(target=each, args=(ended,)) for each in work]
    for thread in threads:
        thread.start()
    try:
        yield
    finally:
        ended.set()
        for thread in threads:
            thread.join(10.0)


def _read(terminal: Any, ended: threading.Event) -> None:
    """As the terminal at the other end of SSH does."""
    while not ended.wait(0.1):
        terminal.lines()


def _poll(daemon: RunningDaemon, ended: threading.Event) -> None:
    with Client(daemon.socket) as client, suppress(DaemonError):
        while not ended.wait(POLL_S):
            client.call("status")
            client.call("checks")


def _download(daemon: RunningDaemon, ended: threading.Event) -> None:
    """The log under way, as a copy over the network would read it: 10 MB/s."""
    while not ended.is_set():
        with daemon.latest_log().open("rb") as file:
            while file.read(1 << 20) and not ended.wait(0.1):
                pass


def _take_all(address: str, ended: threading.Event) -> None:
    with connect(address, subprotocols=["foxglove.sdk.v1"], max_size=None) as window:  # type: ignore[list-item]
        while not ended.is_set():
            with suppress(TimeoutError):
                message = window.recv(timeout=1.0)
                if isinstance(message, str) and '"advertise"' in message:
                    ids = [channel["id"] for channel in json.loads(message)["channels"]]
                    window.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": each, "channelId": each} for each in ids]}))


@contextmanager
def _stalled(daemon: RunningDaemon, served: PageServer) -> Iterator[None]:
    """A client of the socket with a thousand unread answers, and a browser that has stopped reading."""
    with Client(daemon.socket) as client, connect(f"ws://127.0.0.1:{served.port}/live", max_queue=1) as window:
        client._socket.setblocking(False)
        with suppress(BlockingIOError):
            for _ in range(1000):
                client._socket.send(encode({"v": VERSION, "id": 1, "method": "checks", "params": {}}))
        window.send(TOKEN)
        yield


if __name__ == "__main__":
    main()
