"""What an operator can ask of the daemon: one method a verb of the protocol. Runs in the supervisor; the loop gets only commands.

Every refusal says what stands in the way. No methods but `start` and `stream` lead to motion, and they announce it.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from typing import Any

from config.errors import DaemonError
from config.schema.rig import Rig
from daemon.checks.checks import Check, Reaction
from daemon.checks.interlocks import interlocks, not_passed, proof_checks, rest_checks
from daemon.loop.command import NOT_SET_UP, LoopCommand, StartRun
from daemon.modes.mode_machine import SAFE_MODES, OperatorAction
from daemon.server.client_connection import client_has_left
from daemon.server.event_history import RunResult
from daemon.server.live_values import LiveValues, since_t_s, units_answer
from daemon.server.loop_access import ANSWER_LIMIT_S, LoopAccess, SupervisedLoop
from daemon.server.loop_silence import silence_row
from daemon.server.proof_request import proof_answer, proof_countdown_s
from daemon.server.protocol import LONGEST_SETTLE_S
from daemon.server.set_point_requests import SetPointRequests
from daemon.server.start_request import judged_maneuvers, start_run, start_stream
from servo_control.signals import Mode

LONGEST_WAIT_S = 3600.0
SETTLE_POLL_S = 0.02
LONGEST_PROOF_S = 15.0  # of all devices; one takes about half a second
SET_UP_LIMIT_S = 20.0  # of all devices that have lost their settings

Prepare = Callable[[Rig, int, dict[str, Any], list[float]], StartRun]
METHODS = (
    "status", "checks", "units", "rig", "sample", "maneuvers", "wait", "events",
    "prove", "arm", "disarm", "reset", "start", "stream", "stop", "estop", "shutdown",
)  # fmt: skip


class RequestHandlers:
    """`methods`: name in the protocol → what answers it."""

    def __init__(self, rig: Rig, loop: SupervisedLoop, rig_text: str = "") -> None:
        """`rig_text`: the rig file, for `rig` and `units`."""
        self._rig, self._supervised, self._loop, self._rig_text = rig, loop, LoopAccess(loop), rig_text
        self._facts, self._history, self._view = loop.facts, loop.history, loop.view
        self._checks: tuple[Check, ...] = interlocks(rig, loop.facts)
        self._rest_checks = rest_checks(rig, loop.facts)
        self._live = LiveValues(rig, loop.facts)
        self._started = time.monotonic()
        self._runs = 0
        self._interruptions = 0  # what takes a start back that is still being prepared
        self._starting = asyncio.Lock()
        self.host_rows: Callable[[], list[dict[str, Any]]] = list  # what the operating system granted
        self._maneuvers: list[dict[str, Any]] = []
        self.log: dict[str, Any] = {"path": "", "bytes": 0}
        self._set_points = SetPointRequests(rig, loop.history, loop.post_set_point, lambda: self._cancel_announced())
        self.methods: dict[str, Callable[[dict[str, Any]], Awaitable[dict[str, Any]]]] = {name: getattr(self, name) for name in METHODS}
        self.methods["set_point"] = self._set_points.set_point

    async def status(self, params: dict[str, Any]) -> dict[str, Any]:
        answer = self._view.status(self._loop.values(), time.monotonic() - self._started, self._history)
        return {**answer, "loop": {**answer["loop"], "silent_s": self._loop.silent_s()}, "log": dict(self.log)}

    async def checks(self, params: dict[str, Any]) -> dict[str, Any]:
        """A loop that stands still comes first: what it said of the others is old."""
        values, silent_s = self._loop.values(), self._loop.silent_s()
        silence = [silence_row(silent_s)] if silent_s else []
        return {"checks": [*silence, *(check.row(values) for check in self._checks), *self.host_rows()]}

    async def units(self, params: dict[str, Any]) -> dict[str, Any]:
        """How values are shown, by check and joint, and the numbers in sentences; see `units_answer`."""
        return units_answer(self._rig, self._checks, self._rig_text)

    async def rig(self, params: dict[str, Any]) -> dict[str, Any]:
        """The rig file as the daemon has it, and name and SI unit of every number of a sample."""
        return {"name": self._rig.name, "text": self._rig_text, "signals": self._live.signals}

    async def sample(self, params: dict[str, Any]) -> dict[str, Any]:
        """The newest cycle as plain numbers, in the order of `signals` of `rig`; no row when none is later than `since_t_s`."""
        return self._live.sample(self._loop.values(), since_t_s(params))

    async def prove(self, params: dict[str, Any]) -> dict[str, Any]:
        """Every device with outputs shows that it goes safe by itself. Answers with the results when it is over; raises only refusals."""
        mode = self._loop.mode()
        if mode is not Mode.DISARMED:
            advice = "`longreach reset` first." if mode is Mode.FAULT else "`longreach disarm` first."
            raise DaemonError("proof refused", value=mode.name.lower(), limit="disarmed", next_step=advice)
        countdown_s = proof_countdown_s(self._rig, params)
        self._loop.refuse_failed("proof refused", proof_checks(self._rig, self._facts))
        before = self._history.last_number
        command = LoopCommand(OperatorAction.PROVE, countdown_s=countdown_s)
        await self._loop.send(command, lambda: self._loop.mode() is not Mode.PROVING, ANSWER_LIMIT_S + countdown_s + LONGEST_PROOF_S)
        return proof_answer(self._history.since(before), self._loop.mode())

    async def arm(self, params: dict[str, Any]) -> dict[str, Any]:
        """Answers when the arm holds its position. Refused with every check that fails."""
        mode = self._loop.mode()
        if mode is not Mode.DISARMED:
            advice = {Mode.FAULT: "`longreach reset` first.", Mode.PROVING: "Wait until the proof is over."}
            text = advice.get(mode, "It is armed already: `longreach maneuvers` lists what it can run.")
            raise DaemonError("arming refused", value=mode.name.lower(), limit="disarmed", next_step=text)
        self._loop.refuse_failed("arming refused", [check for check in self._checks if check.reaction is not Reaction.WARN])
        self._interruptions += 1
        await self._loop.send(LoopCommand(OperatorAction.ARM), lambda: self._loop.mode() is not Mode.ARMING)
        if self._loop.mode() is not Mode.HOLDING:
            raise DaemonError(
                "arming was given up", value=self._loop.mode().name.lower(), next_step=self._history.last_text("mode", "fault")
            )
        return {"mode": "holding"}

    async def disarm(self, params: dict[str, Any]) -> dict[str, Any]:
        """Safe outputs at once, in any mode; a fault stays latched."""
        self._interruptions += 1
        await self._loop.send(LoopCommand(OperatorAction.DISARM), lambda: self._loop.mode() in SAFE_MODES)
        return {"mode": self._loop.mode().name.lower()}

    async def reset(self, params: dict[str, Any]) -> dict[str, Any]:
        """Release the e-stop latch and a latched fault; ends disarmed. Refused while armed, where it would mean nothing.

        Devices that have lost their settings are set up again first; refused when one of them does not take them.
        """
        if self._loop.mode() not in SAFE_MODES:
            raise DaemonError(
                "nothing to reset", value=self._loop.mode().name.lower(), next_step="Reset clears a fault or the e-stop while disarmed."
            )
        new_recorder = await self._supervised.repair()
        before = self._history.last_number

        def refused() -> str:
            return next((str(event["text"]) for event in self._history.since(before) if event["name"] == NOT_SET_UP), "")

        await self._loop.send(
            LoopCommand(OperatorAction.RESET, new_recorder=new_recorder),
            lambda: bool(self._loop.mode() is Mode.DISARMED or refused()),
            ANSWER_LIMIT_S + SET_UP_LIMIT_S,
        )
        if why := refused():
            raise DaemonError("reset refused", value=self._loop.mode().name.lower(), limit="every device set up", next_step=why)
        await asyncio.sleep(SETTLE_POLL_S)  # what has not gone away is a fault again in the next cycle
        if self._loop.mode() is Mode.FAULT and self._history.fault:
            raise DaemonError(
                "the fault came back at once", value=self._history.fault["text"], next_step="`longreach why` shows the checks."
            )
        return {"mode": "disarmed"}

    async def start(self, params: dict[str, Any]) -> dict[str, Any]:
        """Plan and check the run here, then announce it. Answers before the countdown begins.

        With `settle_s` it waits until the arm is at rest, at most that long. Refused with what still moves, and when it was stopped or the
        client left meanwhile. One start at a time: a second one would begin unexpectedly.
        """
        return await self._announce(start_run, params)

    async def stream(self, params: dict[str, Any]) -> dict[str, Any]:
        """Announce a run that is driven by hand, by whoever asks for it: `set_point` moves the arm once the countdown is over.

        `shaper`, `countdown_s` and `settle_s` as for `start`; the filter is the rig's if none is named.
        """
        answer = await self._announce(start_stream, params)
        self._set_points.begin(answer["run"])
        return answer

    async def _announce(self, prepare: Prepare, params: dict[str, Any]) -> dict[str, Any]:
        if self._starting.locked():
            raise DaemonError("another start is being prepared", next_step="Wait for it, or `longreach stop`.")
        async with self._starting:
            before = self._interruptions
            if "settle_s" in params:
                await self._settle(params.pop("settle_s"), before)
            return await self._start(prepare, params, before)

    async def _settle(self, settle_s: Any, before: int) -> None:
        if isinstance(settle_s, bool) or not isinstance(settle_s, (int, float)) or not 0.0 <= settle_s <= LONGEST_SETTLE_S:
            raise DaemonError("settle_s is not usable", value=repr(settle_s)[:80], limit=f"0 to {LONGEST_SETTLE_S:g}", unit="s")
        limit = time.monotonic() + settle_s
        while self._loop.mode() is Mode.HOLDING and (moving := " ".join(not_passed(self._rest_checks, self._loop.values()))):
            self._refuse_if_taken_back(before, "it waited for the arm to be at rest")
            if time.monotonic() >= limit:
                raise DaemonError(f"start refused: the arm is not at rest after a wait of {settle_s:g} s", next_step=moving)
            await asyncio.sleep(SETTLE_POLL_S)

    async def _start(self, prepare: Prepare, params: dict[str, Any], before: int) -> dict[str, Any]:
        self._refuse_unless_holding()
        while_armed = (Reaction.STOP, Reaction.STOP_THEN_FAULT, Reaction.FAULT)
        self._loop.refuse_failed("start refused", [check for check in self._checks if check.reaction in while_armed])
        values = self._loop.values()
        held = [values[self._facts.index(f"{joint}.reference")] for joint in self._rig.joints]
        start = await asyncio.to_thread(prepare, self._rig, self._runs + 1, params, held)  # a long program takes a while
        self._refuse_unless_holding()
        self._refuse_if_taken_back(before, "it was planned")
        summary = start.plan.summary()
        run = RunResult(self._runs + 1, summary["maneuver"], summary["shaper"], summary["segments"])
        await self._loop.send(LoopCommand(start=start), lambda: True, posted=lambda: self._begin(run))
        return {**summary, "countdown_s": start.countdown_s, "log": self.log["path"]}

    def _begin(self, run: RunResult) -> None:
        """Of a run that the loop will find: one that could not be handed over would never end."""
        self._runs = run.run
        self._history.begin_run(run)

    def _refuse_if_taken_back(self, before: int, while_: str) -> None:
        """A stop before there is a run to stop is meant for the start that is under way; another arming has another position."""
        if self._interruptions != before:
            raise DaemonError(f"start refused: it was stopped while {while_}")
        if client_has_left():
            raise DaemonError(f"start cancelled: who asked for it hung up while {while_}")

    def _refuse_unless_holding(self) -> None:
        run, mode = self._history.last_run, self._loop.mode()
        if run and run.validity == "running":
            advice = "Wait until it has ended, or `longreach stop` it."
            raise DaemonError("start refused", value=f"run {run.run} is announced or under way", limit="no run under way", next_step=advice)
        if mode is Mode.HOLDING:
            return
        fault = self._history.fault
        advice = {Mode.DISARMED: "Run `longreach arm` first.", Mode.FAULT: "Run `longreach reset`, then `longreach arm`."}.get(mode, "")
        because = f" The fault: {fault['text']}" if mode is Mode.FAULT and fault else ""
        text = advice or "Wait, then `longreach status`."
        raise DaemonError("start refused", value=mode.name.lower(), limit="holding with no run under way", next_step=text + because)

    def _cancel_announced(self) -> None:
        """Take back a run that does not move yet."""
        if self._loop.mode() is Mode.HOLDING:
            self._supervised.post(LoopCommand(OperatorAction.STOP))

    async def stop(self, params: dict[str, Any]) -> dict[str, Any]:
        """Controlled stop along the path, then hold; cancels a run that is still being announced, and ends a proof."""
        self._interruptions += 1
        await self._loop.send(LoopCommand(OperatorAction.STOP), lambda: self._loop.mode() not in (Mode.RUNNING, Mode.PROVING))
        return {"mode": self._loop.mode().name.lower()}

    async def estop(self, params: dict[str, Any]) -> dict[str, Any]:
        """Safe outputs at once, latched until a reset."""
        self._interruptions += 1
        await self._loop.send(LoopCommand(OperatorAction.ESTOP), lambda: self._loop.mode() is Mode.FAULT)
        return {"mode": "fault"}

    async def maneuvers(self, params: dict[str, Any]) -> dict[str, Any]:
        """Every shipped maneuver; `reason`: why this rig cannot run it, empty when it can. Planned once: neither changes."""
        if not self._maneuvers:
            self._maneuvers = await asyncio.to_thread(judged_maneuvers, self._rig)
        return {"maneuvers": self._maneuvers}

    async def wait(self, params: dict[str, Any]) -> dict[str, Any]:
        """Until run `run` has ended, at most `timeout_s`; then validity may still be "running"."""
        number = params.get("run", self._runs)
        run = self._history.runs.get(number) if isinstance(number, int) else None
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
        """Events after number `since`, oldest first, and the number of the newest."""
        since = params.get("since", 0)
        if isinstance(since, bool) or not isinstance(since, int):
            raise DaemonError("since must be the number of an event", value=repr(since))
        events = self._history.since(since)
        return {"events": events, "last": events[-1]["n"] if events else since}

    async def shutdown(self, params: dict[str, Any]) -> dict[str, Any]:
        """As SIGTERM: controlled stop, safe outputs, logs closed, end."""
        self._supervised.shut_down()
        return {}
