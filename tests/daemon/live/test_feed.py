"""The one reader of live data against the daemon's own request handlers, over a real socket and a loop in lockstep."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from config.units import to_si
from daemon.live.source.feed import Feed
from daemon.live.source.pending import Pending
from daemon.lockstep import LockstepRig
from daemon.server.socket_server import serve
from tests.support.daemon.lockstep_requests import LockstepRequests
from tests.support.daemon.rigs import RIG

Content = dict[str, Any]


@asynccontextmanager
async def fed(requests: LockstepRequests, socket: Path) -> AsyncIterator[Feed]:
    server = await serve(socket, None, requests.handlers.methods)
    feed = Feed(socket, sample_Hz=500.0)
    running = asyncio.create_task(feed.run())
    try:
        yield feed
    finally:
        running.cancel()
        with suppress(asyncio.CancelledError):
            await running
        await asyncio.sleep(0.01)  # the server sees the connection end
        server.close()
        socket.unlink(missing_ok=True)


async def until(pending: Pending, enough: Callable[[Content], bool]) -> Content:
    """What was handed out until `enough`, samples and events one after the other."""
    seen: Content = {"samples": [], "events": []}
    async with asyncio.timeout(20.0):
        while not enough(seen):
            content = await pending.take()
            for key in ("samples", "events"):
                seen[key] += content.pop(key, [])
            seen |= content
    return seen


@pytest.fixture
def requests(tmp_path: Path) -> Any:
    with LockstepRig(RIG, tmp_path) as rig:
        yield LockstepRequests(rig, RIG.text)


def test_a_view_gets_the_rig_and_every_cycle_once_in_order(requests: LockstepRequests, tmp_path: Path) -> None:
    async def watch() -> Content:
        async with fed(requests, tmp_path / "s") as feed:
            with feed.watched() as pending:
                return await until(pending, lambda seen: len(seen["samples"]) > 20 and "checks" in seen and "status" in seen)

    seen = asyncio.run(watch())
    signals = [signal["name"] for signal in seen["rig"]["signals"]]
    times = [row[1 + seen["rig"]["at_t_s"]] for row in seen["samples"]]
    assert times == sorted(set(times))
    assert all(len(row) == 1 + len(signals) for row in seen["samples"])
    assert len(set(signals)) == len(signals)
    assert not any(name.endswith(("_raw", "_age_s")) for name in signals)
    at = 1 + signals.index("prismatic.position")
    assert seen["samples"][-1][at] == pytest.approx(to_si("40 in", "m"), abs=1e-3)
    assert seen["status"]["mode"] == "disarmed"


def test_shown_values_are_those_of_the_rig_file(requests: LockstepRequests, tmp_path: Path) -> None:
    """Against config.units, one value at a time."""
    requests.rig.cycles(5)

    async def watch() -> Content:
        async with fed(requests, tmp_path / "s") as feed:
            with feed.watched() as pending:
                return await until(pending, lambda seen: "checks" in seen)

    seen = asyncio.run(watch())
    units = {signal["name"]: signal for signal in seen["rig"]["signals"]}
    for name, si, shown in (
        ("rotary.reference", to_si("10 deg", "rad"), 10.0),
        ("prismatic.velocity", to_si("3 in/s", "m/s"), 3.0),
        ("rotary.supply_pressure_Pa", to_si("2000 psi", "Pa"), 2000.0),
        ("rotary.command_V", 1.5, 1.5),
    ):
        assert units[name]["factor"] * si + units[name]["offset"] == pytest.approx(shown), name
    plotted = {name for plot in seen["rig"]["plots"] for name in plot["signals"]}
    assert plotted <= units.keys()
    assert {"rotary.position", "prismatic.target", "tip.acceleration_mps2", "late_us", "reservoir_temperature_C"} <= plotted
    supply = next(check for check in seen["checks"] if check["name"] == "rotary.supply_pressure limit")
    assert supply["unit"] == "psi"
    assert 1500.0 < supply["value"] < 2500.0


def test_nobody_watching_asks_the_daemon_nothing(requests: LockstepRequests, tmp_path: Path) -> None:
    async def watch() -> tuple[int, int]:
        async with fed(requests, tmp_path / "s") as feed:
            with feed.watched() as pending:
                await until(pending, lambda seen: len(seen["samples"]) > 3)
            await asyncio.sleep(0.05)  # the request under way
            before = requests._readings
            await asyncio.sleep(0.2)
            return before, requests._readings

    before, after = asyncio.run(watch())
    assert after == before


def test_a_daemon_that_ends_is_reported_and_one_that_begins_is_followed(requests: LockstepRequests, tmp_path: Path) -> None:
    async def watch() -> list[str]:
        feed = Feed(tmp_path / "s", sample_Hz=500.0)
        running = asyncio.create_task(feed.run())
        with feed.watched() as pending:
            said = [(await until(pending, lambda seen: bool(seen.get("lost"))))["lost"]]
            server = await serve(tmp_path / "s", None, requests.handlers.methods)
            said.append((await until(pending, lambda seen: bool(seen["samples"])))["lost"])
            server.close()
        running.cancel()
        return said

    lost, found = asyncio.run(watch())
    assert "no answer from the daemon" in lost
    assert "longreachd" in lost
    assert found == ""
