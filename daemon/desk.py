"""What an operator can ask of the daemon: one method a verb of the protocol. Runs in the supervisor; the loop only gets requests.

Every refusal says what stands in the way. No method but `start` leads to motion, and `start` announces it.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Sequence
from typing import Any

from config.errors import DaemonError
from config.load import load_maneuver
from config.maneuver import maneuver_content
from config.rig import Rig
from config.shipped import shipped
from control.signals import Mode
from daemon.caller import hung_up
from daemon.checks import Check, Reaction
from daemon.command import NOT_SET_UP, Command
from daemon.facts import Facts
from daemon.interlocks import interlocks, proof_checks
from daemon.journal import Journal, RunResult
from daemon.modes import SAFE_MODES, Event
from daemon.proof_request import proof_answer, proof_countdown_s
from daemon.start_request import start_run
from daemon.status import StatusView
from daemon.swing import not_at_rest, start_checks

ANSWER_LIMIT_S = 5.0  # a healthy loop answers within milliseconds; arming takes a quarter of a second
LONGEST_WAIT_S = 3600.0
LONGEST_SETTLE_S = 600.0
SETTLE_LOOK_S = 0.02
LONGEST_PROOF_S = 15.0  # of all devices; one takes about half a second
SET_UP_LIMIT_S = 20.0  # of all devices that have lost their settings


class Desk:
    """The methods. `values()` gives the loop's latest facts; `post` hands it a command and gives its number, 0 when the
    loop cannot take it; `before_reset` may repair what died."""

    def __init__(
        self,
        rig: Rig,
        facts: Facts,
        journal: Journal,
        view: StatusView,
        values: Callable[[], tuple[float, ...]],
        post: Callable[[Command], int],
        before_reset: Callable[[], Awaitable[None]],
        shutdown: Callable[[], None],
    ) -> None:
        self._rig, self._facts, self._journal, self._view = rig, facts, journal, view
        self._values, self._post, self._before_reset, self._shutdown = values, post, before_reset, shutdown
        self._checks: tuple[Check, ...] = interlocks(rig, facts)
        self._for_start = start_checks(rig, facts)
        self._started = time.monotonic()
        self._runs = self._stops = 0
        self._starting = asyncio.Lock()
        self.host_rows: list[dict[str, Any]] = []  # what the operating system granted
        self.log: dict[str, Any] = {"path": "", "bytes": 0}
        self.methods: dict[str, Callable[[dict[str, Any]], Awaitable[dict[str, Any]]]] = {
            "status": self.status,
            "checks": self.checks,
            "prove": self.prove,
            "arm": self.arm,
            "disarm": self.disarm,
            "reset": self.reset,
            "start": self.start,
            "stop": self.stop,
            "estop": self.estop,
            "maneuvers": self.maneuvers,
            "wait": self.wait,
            "events": self.events,
            "shutdown": self.shutdown,
        }

    async def status(self, params: dict[str, Any]) -> dict[str, Any]:
        answer = self._view.status(self._values(), time.monotonic() - self._started, self._journal)
        return {**answer, "log": dict(self.log)}

    async def checks(self, params: dict[str, Any]) -> dict[str, Any]:
        values = self._values()
        return {"checks": [*(check.row(values) for check in self._checks), *self.host_rows]}

    async def prove(self, params: dict[str, Any]) -> dict[str, Any]:
        """Every device with outputs shows that it goes safe by itself. Answers with the results when it is over; raises only refusals."""
        mode = self._mode()
        if mode is not Mode.DISARMED:
            advice = "`longreach reset` first." if mode is Mode.FAULT else "`longreach disarm` first."
            raise DaemonError("proof refused", value=mode.name.lower(), limit="disarmed", next_step=advice)
        countdown_s = proof_countdown_s(self._rig, params)
        self._refuse_failed("proof refused", proof_checks(self._rig, self._facts))
        before = self._journal.last_number
        command = Command(Event.PROVE, countdown_s=countdown_s)
        await self._send(command, lambda: self._mode() is not Mode.PROVING, ANSWER_LIMIT_S + countdown_s + LONGEST_PROOF_S)
        return proof_answer(self._journal.since(before), self._mode())

    async def arm(self, params: dict[str, Any]) -> dict[str, Any]:
        """Answers when the arm holds its position. Refused with every check that fails."""
        mode = self._mode()
        if mode is not Mode.DISARMED:
            advice = {Mode.FAULT: "`longreach reset` first.", Mode.PROVING: "Wait until the proof is over."}
            text = advice.get(mode, "It is armed already.")
            raise DaemonError("arming refused", value=mode.name.lower(), limit="disarmed", next_step=text)
        self._refuse_failed("arming refused", [check for check in self._checks if check.reaction is not Reaction.WARN])
        await self._send(Command(Event.ARM), lambda: self._mode() is not Mode.ARMING)
        if self._mode() is not Mode.HOLDING:
            raise DaemonError("arming was given up", value=self._mode().name.lower(), next_step=self._journal.last_text("mode", "fault"))
        return {"mode": "holding"}

    async def disarm(self, params: dict[str, Any]) -> dict[str, Any]:
        """Safe outputs at once, in any mode; a fault stays latched."""
        await self._send(Command(Event.DISARM), lambda: self._mode() in SAFE_MODES)
        return {"mode": self._mode().name.lower()}

    async def reset(self, params: dict[str, Any]) -> dict[str, Any]:
        """Release the e-stop latch and a latched fault; ends disarmed. Refused while armed, where it would mean nothing.

        Devices that have lost their settings are set up again first; refused when one of them does not take them.
        """
        if self._mode() not in SAFE_MODES:
            raise DaemonError(
                "nothing to reset", value=self._mode().name.lower(), next_step="Reset clears a fault or the e-stop while disarmed."
            )
        await self._before_reset()
        before = self._journal.last_number

        def refused() -> str:
            return next((str(event["text"]) for event in self._journal.since(before) if event["name"] == NOT_SET_UP), "")

        await self._send(Command(Event.RESET), lambda: bool(self._mode() is Mode.DISARMED or refused()), ANSWER_LIMIT_S + SET_UP_LIMIT_S)
        if why := refused():
            raise DaemonError("reset refused", value=self._mode().name.lower(), limit="every device set up", next_step=why)
        return {"mode": "disarmed"}

    async def start(self, params: dict[str, Any]) -> dict[str, Any]:
        """Plan and check the run here, then announce it. Answers before the countdown begins.

        With `settle_s` it waits until the arm is at rest, at most so long; refused with what still moves, or when it was stopped or its
        client hung up meanwhile. One start at a time: a second one would begin when nobody expects it.
        """
        if self._starting.locked():
            raise DaemonError("another start is being prepared", next_step="Wait for it, or `longreach stop`.")
        async with self._starting:
            if "settle_s" in params:
                await self._settle(params.pop("settle_s"))
            return await self._start(params)

    async def _settle(self, settle_s: Any) -> None:
        if isinstance(settle_s, bool) or not isinstance(settle_s, (int, float)) or not 0.0 <= settle_s <= LONGEST_SETTLE_S:
            raise DaemonError("settle_s is not usable", value=repr(settle_s)[:80], limit=f"0 to {LONGEST_SETTLE_S:g}", unit="s")
        limit, stops = time.monotonic() + settle_s, self._stops
        while self._mode() is Mode.HOLDING and (moving := " ".join(not_at_rest(self._for_start, self._values()))):
            if self._stops != stops:
                raise DaemonError("start refused: it was stopped while it waited for the arm to be at rest")
            if hung_up():
                raise DaemonError("start cancelled: who asked for it hung up while it waited for the arm to be at rest")
            if time.monotonic() >= limit:
                raise DaemonError(f"start refused: the arm is not at rest after a wait of {settle_s:g} s", next_step=moving)
            await asyncio.sleep(SETTLE_LOOK_S)

    async def _start(self, params: dict[str, Any]) -> dict[str, Any]:
        mode = self._mode()
        if mode is not Mode.HOLDING or (self._journal.last_run and self._journal.last_run.validity == "running"):
            advice = {Mode.DISARMED: "Run `longreach arm` first.", Mode.FAULT: "Run `longreach reset`, then `longreach arm`."}
            text = advice.get(mode, "Wait until the run under way has ended, or `longreach stop` it.")
            raise DaemonError("start refused", value=mode.name.lower(), limit="holding with no run under way", next_step=text)
        while_armed = (Reaction.STOP, Reaction.STOP_THEN_FAULT, Reaction.FAULT)
        self._refuse_failed("start refused", [check for check in self._checks if check.reaction in while_armed])
        values = self._values()
        held = [values[self._facts.index(f"{joint}.reference")] for joint in self._rig.joints]
        start = await asyncio.to_thread(start_run, self._rig, self._runs + 1, params, held)  # a long program takes a while
        self._runs += 1
        summary = start.plan.summary()
        self._journal.begin_run(RunResult(self._runs, summary["maneuver"], summary["shaper"], summary["segments"]))
        await self._send(Command(start=start), lambda: True)
        return {**summary, "countdown_s": start.countdown_s, "log": self.log["path"]}

    async def stop(self, params: dict[str, Any]) -> dict[str, Any]:
        """Controlled stop along the path, then hold; cancels a run that is still being announced, and ends a proof."""
        self._stops += 1
        await self._send(Command(Event.STOP), lambda: self._mode() not in (Mode.RUNNING, Mode.PROVING))
        return {"mode": self._mode().name.lower()}

    async def estop(self, params: dict[str, Any]) -> dict[str, Any]:
        """Safe outputs at once, latched until a reset."""
        await self._send(Command(Event.ESTOP), lambda: self._mode() is Mode.FAULT)
        return {"mode": "fault"}

    async def maneuvers(self, params: dict[str, Any]) -> dict[str, Any]:
        contents = [maneuver_content(load_maneuver(path).maneuver) for path in shipped("maneuvers").values()]
        return {"maneuvers": [{key: content[key] for key in ("name", "kind", "description")} for content in contents]}

    async def wait(self, params: dict[str, Any]) -> dict[str, Any]:
        """Until run `run` has ended, at most `timeout_s`; then validity may still be "running"."""
        number = params.get("run", self._runs)
        run = self._journal.runs.get(number) if isinstance(number, int) else None
        if run is None:
            raise DaemonError(
                "no such run", value=repr(number)[:80], limit=f"1 to {self._runs}", next_step="Run numbers start anew with the daemon."
            )
        timeout_s = params.get("timeout_s", LONGEST_WAIT_S)
        if isinstance(timeout_s, bool) or not isinstance(timeout_s, (int, float)) or not 0.0 <= timeout_s <= LONGEST_WAIT_S:
            raise DaemonError("timeout_s is not usable", value=repr(timeout_s), limit=f"0 to {LONGEST_WAIT_S:g}", unit="s")
        limit = time.monotonic() + timeout_s
        while run.validity == "running" and time.monotonic() < limit:
            await asyncio.sleep(0.02)
        return {"run": run.run, "validity": run.validity, "reason": run.reason, "log": self.log["path"]}

    async def events(self, params: dict[str, Any]) -> dict[str, Any]:
        since = params.get("since", 0)
        if isinstance(since, bool) or not isinstance(since, int):
            raise DaemonError("since must be the number of an event", value=repr(since))
        events = self._journal.since(since)
        return {"events": events, "last": events[-1]["n"] if events else since}

    async def shutdown(self, params: dict[str, Any]) -> dict[str, Any]:
        """As SIGTERM: controlled stop, safe outputs, logs closed, end."""
        self._shutdown()
        return {}

    def _mode(self) -> Mode:
        return self._view.mode(self._values())

    def _refuse_failed(self, what: str, checks: Sequence[Check]) -> None:
        values = self._values()
        failed = [check for check in checks if not check.passes(values)]
        if failed:
            sentences = " ".join(check.sentence(values) for check in failed)
            names = ", ".join(check.name for check in failed)
            raise DaemonError(f"{what}: {len(failed)} of {len(checks)} checks fail", value=names, next_step=sentences)

    async def _send(self, command: Command, done: Callable[[], bool], limit_s: float = ANSWER_LIMIT_S) -> None:
        """Hand the loop a command and wait until it has carried it out and `done()`. DaemonError when it does not in time."""
        index = self._facts.index("commands")
        number = self._post(command)
        if not number:
            raise DaemonError("the loop does not fetch its commands", next_step="See `systemctl status longreachd`.")
        limit = time.monotonic() + limit_s
        while not (self._values()[index] >= number and done()):
            if time.monotonic() > limit:
                value = self._mode().name.lower()
                raise DaemonError(
                    "the loop did not do it in time", value=value, limit=limit_s, unit="s", next_step="Try `longreach estop`."
                )
            await asyncio.sleep(0.005)
