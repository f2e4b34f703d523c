"""Set points of whoever drives by hand: `set_point` of the protocol. One client owns a run; only its set points count.

Whatever a set point holds reaches the loop or is refused with an error. One that is none (a joint that the rig has not, a text for a
number) stops the arm like a number that is not finite: its sender does not know what it does.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping
from math import isfinite, nan
from typing import Any

from config.errors import DaemonError
from config.schema.rig import Rig
from daemon.server.client_connection import client
from daemon.server.event_history import EventHistory
from servo_control.signals import SetPoint, Wanted

_WANTED = {"rate": Wanted.RATE, "target": Wanted.TARGET, "tip_mps": Wanted.TIP}
_KEYS = {"run", "t_s", "end", *_WANTED}
LEFT_POLL_S = 0.01
CLOCK_DRIFT = 2e-4  # by which the client's clock may differ from ours

Post = Callable[[SetPoint], None]


class Lateness:
    """How much later than the quickest one a set point came, from the client's clock, which may be any: only differences count."""

    def __init__(self) -> None:
        self._least_s = self._last_s = nan

    def of(self, sent_s: float, now_s: float) -> float:
        delay = now_s - sent_s
        drifted = self._least_s + CLOCK_DRIFT * (now_s - self._last_s)
        self._least_s = drifted if drifted < delay else delay
        self._last_s = now_s
        return delay - self._least_s


class SetPointRequests:
    """`begin` when a client's run was announced; then `set_point` answers that client."""

    def __init__(self, rig: Rig, history: EventHistory, post: Post, cancel: Callable[[], None]) -> None:
        """`cancel` takes back a run that is still being announced."""
        self._joints, self._history, self._post, self._cancel = tuple(rig.joints), history, post, cancel
        self._has_tip = rig.arm.kind == "rotary_prismatic"
        self._run = 0
        self._owner: Callable[[], bool] = lambda: True
        self._over = "none was begun"
        self._lateness = Lateness()
        self._watching: asyncio.Task[None] | None = None

    def begin(self, run: int) -> None:
        """Who asked for this run drives it."""
        self._run, self._owner, self._over, self._lateness = run, client(), "", Lateness()
        self._watching = asyncio.create_task(self._watch(run))

    async def set_point(self, params: dict[str, Any]) -> dict[str, Any]:
        """Hand the loop a set point. Answers with how the run stands, and does not wait for the loop."""
        self._refuse_others(params)
        try:
            point = self._parsed(params)
        except DaemonError as error:
            self._send(SetPoint(self._run, Wanted.RATE, (nan,) * len(self._joints), 0.0), over=str(error))
            raise
        bad = "" if all(map(isfinite, point.values)) else "a set point was no finite number"
        self._send(point, over="its driver ended it" if point.wanted == Wanted.END else bad)
        return {"run": self._run, "validity": self._history.runs[self._run].validity}

    def _send(self, point: SetPoint, over: str) -> None:
        """The loop takes the newest set point: what ends the run must not be overtaken, and takes back one that does not move yet. `over`:
        why it ends the run; nothing where it goes on."""
        self._over = over
        self._post(point)
        if over:
            self._cancel()

    def _refuse_others(self, params: Mapping[str, Any]) -> None:
        run = self._history.runs.get(self._run)
        if run is None or params.get("run") != self._run:
            advice = "Ask for one with `stream`, and give the `run` of its answer."
            raise DaemonError(
                "no such run is driven by hand", value=repr(params.get("run"))[:80], limit=self._run or "none", next_step=advice
            )
        if client() is not self._owner:
            raise DaemonError("another client drives this run", value=self._run, next_step="Only who asked for a run drives it.")
        if self._over or run.validity != "running":
            raise DaemonError(
                "the run is over", value=run.reason or self._over or run.validity, next_step="Ask for another one with `stream`."
            )

    def _parsed(self, params: Mapping[str, Any]) -> SetPoint:
        unknown = sorted(set(params) - _KEYS)
        wanted = [key for key in (*_WANTED, "end") if key in params]
        if unknown or len(wanted) != 1:
            advice = 'Example: {"run": 1, "rate": {"rotary": 0.1}, "t_s": 12.34}.'
            limit = "one of rate, target, tip_mps, end; and run, t_s"
            raise DaemonError("a set point has wrong keys", value=", ".join(unknown or wanted) or "none", limit=limit, next_step=advice)
        late_s = self._late_s(params["t_s"]) if "t_s" in params else 0.0
        if "end" in params:
            return SetPoint(self._run, Wanted.END, (), late_s)
        key = wanted[0]
        values = self._of_tip(params[key]) if key == "tip_mps" else self._of_joints(params[key], complete=key == "target")
        return SetPoint(self._run, _WANTED[key], values, late_s)

    def _late_s(self, sent_s: Any) -> float:
        number = _number(sent_s)
        if not isfinite(number):
            raise DaemonError("t_s of a set point is no time", value=repr(sent_s)[:80], unit="s")
        return self._lateness.of(number, time.monotonic())

    def _of_joints(self, values: Any, complete: bool) -> tuple[float, ...]:
        """Joints that are not named have the rate 0; a target needs all of them."""
        if not isinstance(values, Mapping) or set(values) - set(self._joints) or (complete and len(values) < len(self._joints)):
            what = "a target names every joint" if complete else "a rate names joints of the rig"
            raise DaemonError(what, value=repr(values)[:80], limit=", ".join(self._joints))
        return tuple(_number(values.get(joint, 0.0)) for joint in self._joints)

    def _of_tip(self, values: Any) -> tuple[float, ...]:
        if not self._has_tip or not isinstance(values, list) or len(values) != 2:
            raise DaemonError("the tip's velocity is [x, y] in m/s, of an arm that is rotary and prismatic", value=repr(values)[:80])
        return tuple(map(_number, values))

    async def _watch(self, run: int) -> None:
        """A client that hangs up without an end of its run stops the arm at once; the time-out would a little later."""
        while self._run == run and not self._over and self._history.runs[run].validity == "running":
            if self._owner():
                self._send(SetPoint(run, Wanted.CLIENT_LEFT, (), 0.0), over="its client hung up")
                return
            await asyncio.sleep(LEFT_POLL_S)


def _number(value: Any) -> float:
    """NaN for what is none; the protocol writes null for a number that is not finite."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return nan
    try:
        return float(value)
    except OverflowError:  # a whole number beyond all floats
        return nan
