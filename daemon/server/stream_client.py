"""Driving by hand from a program: ask for a run, then send set points. Standard library alone.

    with Client(socket_path()) as client, Stream(client) as stream:
        stream.wait_until_driving()
        while wanted():
            stream.rate(rotary=0.1)     # rad/s and m/s; again and again, at least every 50 ms

Each call waits for its answer, some 0.2 to 1 ms. Leaving the `with` ends the run: the arm slows down and holds.
"""

from __future__ import annotations

import time
from contextlib import suppress
from types import TracebackType
from typing import Any

from config.errors import DaemonError
from daemon.server.protocol import Client

POLL_S = 0.01
END_LIMIT_S = 10.0


class Stream:
    """A run that is driven by hand. `limits`: of every joint, as the daemon answered; `run`: its number."""

    def __init__(
        self, client: Client, shaper: dict[str, Any] | None = None, countdown_s: float | None = None, settle_s: float = 0.0
    ) -> None:
        """Asks for the run at once. Raises the daemon's refusal: not armed, a filter that cannot be used, an arm that still moves."""
        params: dict[str, Any] = {"shaper": shaper, "countdown_s": countdown_s, "settle_s": settle_s or None}
        self._client = client
        self.answer = client.call("stream", **{key: value for key, value in params.items() if value is not None})
        self.run: int = self.answer["run"]
        self.limits: dict[str, dict[str, Any]] = self.answer["limits"]
        self._result: dict[str, Any] | None = None

    def wait_until_driving(self) -> None:
        """Through the countdown. DaemonError when the run was stopped meanwhile."""
        while (mode := self._client.call("status")["mode"]) != "running":
            result = self._client.call("wait", run=self.run, timeout_s=0.0)
            if result["validity"] != "running":
                raise DaemonError("the run was not started", value=mode, next_step=result["reason"])
            time.sleep(POLL_S)

    def rate(self, **joints: float) -> None:
        """Rates in rad/s or m/s; joints that are not named stand still. Raises why the run is over when it is."""
        self._send(rate=self._of_rig(joints))

    def target(self, **joints: float) -> None:
        """Positions of every joint in rad or m: the arm goes there as fast as it may."""
        self._send(target=self._of_rig(joints))

    def tip(self, x_mps: float, y_mps: float) -> None:
        """Velocity of the tip in the plane: y along the arm at rotary 0, x to the right of it."""
        self._send(tip_mps=[x_mps, y_mps])

    def _of_rig(self, joints: dict[str, float]) -> dict[str, float]:
        """A slip in a name is refused here: one that reached the loop would end the run."""
        if unknown := sorted(joints.keys() - self.limits.keys()):
            raise DaemonError("no such joint", value=", ".join(unknown), limit=", ".join(self.limits))
        return joints

    def _send(self, **wanted: Any) -> None:
        self._client.call("set_point", run=self.run, t_s=time.monotonic(), **wanted)

    def end(self) -> dict[str, Any]:
        """Slow down, come to rest; then how the run ended: validity, reason and log. Once it has, the same again."""
        if self._result is None:
            with suppress(DaemonError):  # it is over already
                self.wait_until_driving()  # before that nobody takes the end
                self._client.call("set_point", run=self.run, end=True)
            self._result = self._client.call("wait", run=self.run, timeout_s=END_LIMIT_S)
        return self._result

    def __enter__(self) -> Stream:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """After an error the client's hanging up or the time-out stops the arm as well; this is sooner. DaemonError when the run is not
        valid and nobody has asked how it ended."""
        asked = self._result is not None
        if kind is None or not issubclass(kind, (OSError, DaemonError)):
            ended = self.end()
            if kind is None and not asked and ended["validity"] == "invalid":
                raise DaemonError("the run is not valid", value=ended["reason"], where=str(ended["log"]))
