"""A client that drives by hand over the protocol, in lockstep, and the states that it can bring a rig to."""

from __future__ import annotations

from typing import Any

from daemon.lockstep import LockstepRig
from daemon.server.client_connection import answer_for_client
from servo_control.signals import Mode
from tests.support.daemon.lockstep_requests import LockstepRequests

GOOD = {"rate": {"rotary": 0.3}}


class Owner:
    """A client; `gone` once it has hung up."""

    def __init__(self) -> None:
        self.gone = False

    def __call__(self) -> bool:
        return self.gone


class Driver:
    """Asks for a run and drives it, as one client."""

    def __init__(self, requests: LockstepRequests) -> None:
        self.requests, self.owner, self.run = requests, Owner(), 0
        self.rig = requests.rig

    async def call(self, method: str, **params: Any) -> dict[str, Any]:
        answer_for_client(self.owner)
        return await self.requests.handlers.methods[method](params)

    async def begin(self, **params: Any) -> None:
        await self.call("reset")
        await self.call("arm")
        self.run = (await self.call("stream", **{"countdown_s": 0.0, **params}))["run"]

    async def driving(self) -> None:
        await self.begin()
        self.rig.until(lambda: self.rig.mode is Mode.RUNNING)
        await self.send(60)

    async def send(self, cycles: int, **point: Any) -> None:
        for _ in range(cycles // 20):
            await self.call("set_point", run=self.run, **(point or GOOD))
            self.rig.cycles(20)

    async def settled(self) -> dict[str, Any]:
        """The run's end."""
        self.rig.until(lambda: self.rig.mode in (Mode.HOLDING, Mode.FAULT, Mode.DISARMED) and not self.rig.loop.keeper.run.active)
        self.requests.values()
        return await self.call("wait", run=self.run, timeout_s=0.0)


def target(rig: LockstepRig) -> float:
    return rig.value("rotary.target")


async def disarmed(driver: Driver) -> None:
    await driver.call("reset")


async def holding(driver: Driver) -> None:
    await driver.call("reset")
    await driver.call("arm")


async def announced(driver: Driver) -> None:
    await driver.begin(countdown_s=5.0)
    driver.rig.cycles(50)


async def driving(driver: Driver) -> None:
    await driver.driving()


async def ending(driver: Driver) -> None:
    await driver.driving()
    await driver.call("set_point", run=driver.run, end=True)
    driver.rig.cycles(3)


async def ended(driver: Driver) -> None:
    await ending(driver)
    await driver.settled()


async def maneuver(driver: Driver) -> None:
    await driver.call("reset")
    await driver.call("arm")
    maneuver = {"name": "jog"}
    driver.run = (
        await driver.call("start", maneuver=maneuver, parameters={"joint": "prismatic", "by": "1 in", "speed": "1 in/s"}, countdown_s=0.0)
    )["run"]
    driver.rig.until(lambda: driver.rig.mode is Mode.RUNNING)


async def fault(driver: Driver) -> None:
    await driver.driving()
    await driver.call("estop")
