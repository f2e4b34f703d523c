"""The devices as a cycle uses them. Whatever a driver raises makes the outputs safe and is a fault; it never ends the loop."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from daemon.checks.safe_state import SafeState
from daemon.cycle.log_stream import LogStream
from daemon.loop.command import NOT_SET_UP
from daemon.loop.device_bank import DeviceBank
from daemon.loop.recording_span import OUTPUTS_ACT, RecordingSpan
from daemon.modes.mode_keeper import ModeKeeper
from recording.format.event import Level
from servo_control.signals import Mode


class GuardedDevices:
    """Reads, writes and changes of mode of all devices, and the proof of their safe state."""

    def __init__(self, bank: DeviceBank, safe_state: SafeState, keeper: ModeKeeper, span: RecordingSpan, log: LogStream) -> None:
        self._bank, self._safe_state, self._keeper, self._span, self._log = bank, safe_state, keeper, span, log
        self._error_logged = False  # of this mode: a driver may raise in every cycle

    def read(self, now_ns: int, values: list[float]) -> None:
        """Every signal into the facts; proofs that a device has lost no longer count."""
        try:
            self._bank.read(now_ns, values)
        except Exception as error:  # whatever a driver raises: its inputs are unknown, so outputs become safe
            self._failed("read", error)
        try:
            self._safe_state.follow(values)
        except Exception as error:  # whatever a driver raises
            self._failed("to say whether it was set up", error)

    def write(self, volts: Sequence[float], now_ns: int, values: list[float]) -> None:
        """Commands where outputs act, a step of the proof where that is under way, nothing in other modes."""
        mode = self._keeper.mode
        try:
            if mode in OUTPUTS_ACT:
                self._bank.write(volts, now_ns)
            elif mode is Mode.PROVING:
                self._safe_state.step(values)
                self._keeper.conditions.proof_over = self._safe_state.over
        except Exception as error:  # whatever a driver raises
            self._failed("write" if mode is not Mode.PROVING else "the proof", error)

    def mode_changed(self, before: Mode, mode: Mode, values: list[float], countdown_s: float) -> None:
        """Outputs follow the mode. `countdown_s`: announcement of a proof that begins."""
        self._error_logged = False
        if mode is Mode.ARMING:
            self._begin("activate", self._bank.activate)
        elif mode is Mode.PROVING:
            self._keeper.conditions.proof_over = False
            self._begin("the proof", lambda: self._safe_state.begin(values, countdown_s))
        elif before is Mode.PROVING:
            self._safe_state.give_up()
            self._guarded("safe", self._bank.safe)
        elif mode not in OUTPUTS_ACT and before in OUTPUTS_ACT:
            self._guarded("safe", self._bank.safe)

    @property
    def needs_setup(self) -> bool:
        """Also where a device cannot say."""
        try:
            return self._bank.needs_setup
        except Exception:  # whatever a driver raises: setting it up will show
            return True

    def set_up_again(self, between: Callable[[], None]) -> bool:
        """False when a device refuses, which is a fault and an event; `between` is called after each device."""
        try:
            self._bank.set_up_again(between)
        except Exception as error:  # whatever a driver raises
            self._log.event(Level.ERROR, NOT_SET_UP, f"a device could not be set up again: {error}")
            self._keeper.fail(f"a device refused its settings: {error}")
            return False
        self._log.event(Level.INFO, "set_up", "the devices were set up again, read back and compared")
        return True

    def end(self, close_recording: Callable[[], None]) -> None:
        """Safe outputs, then the recording, then the devices are closed; each also when the one before raises."""
        self._safe_state.give_up()
        try:
            self._bank.safe()
        finally:
            close_recording()
            self._bank.close()

    def _begin(self, verb: str, action: Callable[[], None]) -> None:
        """What some devices have begun when one refuses must end with safe outputs on all."""
        try:
            action()
        except Exception as error:  # whatever a driver raises
            self._failed(verb, error)

    def _failed(self, verb: str, error: Exception) -> None:
        if self._keeper.mode is not Mode.FAULT:
            self._span.mode_changed()
        self._keeper.fail(f"a device refused {verb}: {error}")
        self._safe_state.give_up()
        self._guarded("safe", self._bank.safe)

    def _guarded(self, verb: str, action: Callable[[], None]) -> None:
        try:
            action()
        except Exception as error:  # whatever a driver raises, perhaps in every cycle from now on
            if not self._error_logged:
                self._log.event(Level.ERROR, "device", f"a device refused {verb}: {error}")
            self._error_logged = True
            self._keeper.fail(f"a device refused {verb}: {error}")
