"""What CANopen devices with outputs share: nothing acts before activate(), every way out is safe, and safe is seen to be safe.

While active the device hears a command from us in every cycle, and while not, that it is to stay safe; so its own supervision acts
when the loop dies. safe() itself never waits, because the next device must become safe too: the following reads watch whether this
one says that it is, and raise when it does not.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from enum import StrEnum
from math import isfinite
from typing import NoReturn, TypeVar

from config.errors import DriverError
from config.options.canopen_options import CanopenOptions
from drivers.canopen.bus import Steps
from drivers.canopen.device import CanopenDevice
from drivers.contract import Sample
from drivers.proof import ProofResult, ProofSteps

ACTIVATE_S = 0.05  # a device takes one or two SYNC periods a state
CLOSE_S = 0.05
T = TypeVar("T")


class Silence(StrEnum):
    """What we stop sending."""

    HEARTBEAT = "a missed heartbeat"
    COMMANDS = "missing set points"


class OutputDevice(CanopenDevice):
    """Base of valves and output modules. `patience`: how many cycles in a row it may be in another state than commanded."""

    def __init__(
        self, name: str, options: CanopenOptions, timeout_s: float, heartbeat_period_s: float, lockstep: bool, patience: int
    ) -> None:
        super().__init__(name, options, heartbeat_period_s, lockstep)
        self._timeout_s = timeout_s
        self._patience = patience
        self._active = False
        self._proving = False  # the output is off its safe value on purpose
        self._bad_cycles = 0
        self._confirm_from = 0  # the frame from which on it must say that it is safe; 0: nothing to confirm

    def configure(self) -> None:
        """As CanopenDevice; nothing acts afterwards."""
        self._active = self._proving = False
        self._bad_cycles = self._confirm_from = 0
        super().configure()

    def activate(self) -> None:
        """Clears what may be cleared and sees the device ready, its outputs safe. DriverError when it does not get there."""
        bus = self._opened()
        if not self._configured:
            raise self._error("the device is not configured", next_step="Call configure() before activate().")
        bus.run(self._make_ready())
        self._bad_cycles = self._confirm_from = self.emergency = 0
        self._active = True

    def write(self, values: Sequence[float], now_ns: int) -> None:
        self._opened()
        if not self._active:
            raise self._error("the device is not active", next_step="Call activate() before write().")
        if len(values) != len(self.outputs) or not all(map(isfinite, values)):
            self._send_safe_command()
            raise self._error(
                f"a finite number is needed for each of {len(self.outputs)} outputs", list(values), next_step="Outputs are safe now."
            )
        if self._is_right():
            self._bad_cycles = 0
        else:
            self._bad_cycles += 1
        if self._bad_cycles > self._patience:
            self._send_safe_command()
            raise self._error(
                self._trouble(), f"{self._bad_cycles} cycles in a row", self._patience, next_step="Read the device's fault memory."
            )
        self._command(values)

    def read(self, now_ns: int) -> Sequence[Sample]:
        samples = super().read(now_ns)
        if self._configured and not self._active and not self._proving:
            self._send_safe_command()
            self._watch_safe()
        return samples

    def safe(self) -> None:
        """Tells the device to be safe. The next reads raise DriverError when it does not say that it is."""
        acted = self._active or self._proving
        self._active = self._proving = False
        if self._bus is None or not self._configured:
            return
        self._send_safe_command()
        if acted and self.outputs:
            self._bad_cycles = 0
            self._confirm_from = self.received + 2  # one frame may be on its way that answers an earlier SYNC

    def close(self) -> None:
        """safe(), waits until the device says that it is, and gives the bus back. DriverError when it does not."""
        try:
            self.safe()
            if self._confirm_from and not self._opened().run(self._answers(self._is_safe, CLOSE_S, self._send_safe_command)):
                raise self._not_confirmed()
        finally:
            self._confirm_from = 0
            super().close()

    def prove_safe_state(self) -> ProofSteps:
        """We fall silent in each way that the device supervises; each time it must go safe by itself (see drivers.proof)."""
        if not self.outputs:
            return
        for silence in self._supervised():
            yield (yield from self._undisturbed(self._prove(silence)))
        yield from self._undisturbed(self._end_proof())  # the proofs of others on the bus have disturbed it

    def _undisturbed(self, steps: Steps[T]) -> Steps[T]:
        """The steps, in which nobody else tells the device to be safe."""
        bus = self._opened()
        self._proving = True
        try:
            result = yield from steps
        finally:
            bus.heartbeat_withheld = False
        self._proving = False
        return result

    def _fall_silent(
        self, silence: Silence, reacted: Callable[[], bool], limit_s: float, send_command: Callable[[], None]
    ) -> Steps[float | None]:
        """The seconds from our last sign of life to the frame that shows the device's reaction; None when it does not come."""
        bus = self._opened()
        bus.heartbeat_withheld = silence is Silence.HEARTBEAT
        last_sign_ns = bus.heartbeat_sent_ns if bus.heartbeat_withheld else time.monotonic_ns()
        give_up_ns = last_sign_ns + round(2e9 * limit_s)
        if not bus.heartbeat_withheld:
            send_command()
        while not reacted():
            if time.monotonic_ns() > give_up_ns:
                return None
            if bus.heartbeat_withheld:
                send_command()
            yield
        return (self.heard_ns - last_sign_ns) * 1e-9

    def _on_emergency(self, data: bytearray, stamp_ns: int) -> None:
        """An error of the device's own: whether it would still go safe must be seen anew."""
        super()._on_emergency(data, stamp_ns)
        if self.outputs and self.emergency and not self._missed_us:
            self._lose_setup("reported an error of its own")

    def _refuse_to_go_on(self) -> NoReturn:
        if self._configured and not (self._active or self._proving):
            self._send_safe_command()
        super()._refuse_to_go_on()

    @property
    def _way_back(self) -> str:
        proof = " Its proof no longer counts: take the pressure off and run `longreach prove`." if self.outputs else ""
        return super()._way_back + proof

    @property
    def _reacts_to_us(self) -> bool:
        return self._proving or super()._reacts_to_us

    def _watch_safe(self) -> None:
        if not self._confirm_from:
            return
        self._bad_cycles += 1
        if self.received >= self._confirm_from and self._is_safe():
            self._confirm_from = 0
        elif self._bad_cycles > self._patience:
            self._confirm_from = 0
            raise self._not_confirmed()

    def _not_confirmed(self) -> DriverError:
        next_step = f"Its own supervision acts {1e3 * self._timeout_s:.0f} ms after our last frame: take the pressure off."
        return self._error("the device did not confirm that it is safe", self._trouble(), next_step=next_step)

    def _make_ready(self) -> Steps[None]:
        """For subclasses: bring the device to the state from which the first write acts."""
        raise NotImplementedError

    def _supervised(self) -> Sequence[Silence]:
        """For subclasses: the silences of ours that the device supervises."""
        raise NotImplementedError

    def _prove(self, silence: Silence) -> Steps[ProofResult]:
        """For subclasses: open the output a little, fall silent, watch, and make it safe again."""
        raise NotImplementedError

    def _end_proof(self) -> Steps[None]:
        """For subclasses: no fault is left, and the output is safe."""
        raise NotImplementedError

    def _command(self, values: Sequence[float]) -> None:
        """For subclasses: send the outputs."""
        raise NotImplementedError

    def _send_safe_command(self) -> None:
        """For subclasses: send what makes it safe."""
        raise NotImplementedError

    def _is_right(self) -> bool:
        """For subclasses: an active device is as it must be."""
        raise NotImplementedError

    def _is_safe(self) -> bool:
        """For subclasses: what the last frame says."""
        raise NotImplementedError

    def _trouble(self) -> str:
        """For subclasses: what is wrong, in words."""
        raise NotImplementedError
