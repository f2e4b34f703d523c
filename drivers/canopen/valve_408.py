"""Proportional and servo valves after CiA 408: spool set point and device control out, actual spool and status word in.

Every write takes the valve a step nearer to ACTIVE and gives it the set point; it follows the set point in ACTIVE only. A fault of the
valve's own is reset once, by activate(), because that is what an operator asked for; never in the loop.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

import can

from config.options.canopen_options import ValveOptions
from config.options.canopen_rig import our_heartbeat_period_s
from config.options.driver_options import device_options
from config.schema.rig import Device, Rig
from drivers.canopen.bus import Steps
from drivers.canopen.node_setup import (
    AT_ONCE,
    I8,
    I16,
    ON_SYNC,
    U8,
    U16,
    NodeSetup,
    Setting,
    pdo_settings,
    supervision,
)
from drivers.canopen.output_device import ACTIVATE_S, OutputDevice, Silence
from drivers.canopen.valve_states import FAILSAFE, FAULTS, RESET, SAFE, ValveState, control_word, state_of
from drivers.contract import Quality
from drivers.proof import ProofResult, not_proven, proof

FULL_SPOOL = 16384  # counts of 100 % (0x6311)
OPEN_S = 0.2  # to become ACTIVE, and the spool's stroke
REACTION_S = 0.03  # from the end of a time-out until the spool stands still
_COMMAND, _STATUS = struct.Struct("<Hh"), struct.Struct("<Hh")
_COMMAND_MAPPING, _STATUS_MAPPING = (0x60400010, 0x63000110), (0x60410010, 0x63010110)
_BUS_SET_POINT, _KEEP_RUNNING = 1, 1  # device mode: set point by bus; 0x1029: stay operational, so that the status goes on coming


def create(name: str, device: Device, rig: Rig, lockstep: bool) -> ValveDriver:
    """The driver factory (`driver: canopen_valve_408` in a rig file)."""
    options = device_options(name, device)
    assert isinstance(options, ValveOptions)
    return ValveDriver(name, options, device.timeout_s, our_heartbeat_period_s(rig, options.bus), lockstep)


class ValveDriver(OutputDevice):
    """Output `spool`: 1 = 100 %. Inputs `spool` (16384 = 100 %) and `status`, the status word. `state` is the last state heard."""

    def __init__(self, name: str, options: ValveOptions, timeout_s: float, heartbeat_period_s: float, lockstep: bool) -> None:
        super().__init__(name, options, timeout_s, heartbeat_period_s, lockstep, options.wrong_state_cycles)
        self._valve = options
        self._safe_state = ValveState.HOLD if options.safe_state == "hold" else ValveState.DISABLED
        self._spool, self._status = self._samples
        self._message = can.Message(arbitration_id=0x200 + self.node, is_extended_id=False, data=bytes(_COMMAND.size))
        self.state = ValveState.UNKNOWN

    def _set_up(self, setup: NodeSetup) -> None:
        valve, own = self._valve, self._valve.bus.own_node
        setup.write(
            [
                Setting(0x6040, 0, control_word(ValveState.UNKNOWN, ValveState.DISABLED), U16, "control word: disabled"),
                Setting(0x6300, 1, 0, I16, "spool set point"),
                Setting(0x6042, 0, _BUS_SET_POINT, I8, "device mode: set point by bus"),
                Setting(0x6043, 0, valve.control_mode, I8, "control mode"),
                Setting(0x6314, 1, round(FULL_SPOOL * valve.hold_spool), I16, "spool hold set point"),
                *(Setting(0x2830, sub, value, U8, "fault reaction") for sub, value in valve.fault_reactions.items()),
                Setting(0x1029, 1, _KEEP_RUNNING, U8, "error behaviour: no NMT state change"),
            ]
        )
        deadline_ms = round(1e3 * self._timeout_s) if valve.deadline else None
        setup.write(pdo_settings(True, 1, self.node, ON_SYNC if valve.set_point_on_sync else AT_ONCE, _COMMAND_MAPPING, deadline_ms))
        setup.write(pdo_settings(False, 1, self.node, ON_SYNC, _STATUS_MAPPING))
        setup.switch_off_other_pdos([(True, 1), (False, 1)])
        setup.write(list(supervision(own, self._timeout_s)))

    def _supervised(self) -> Sequence[Silence]:
        return (Silence.HEARTBEAT, Silence.COMMANDS) if self._valve.deadline else (Silence.HEARTBEAT,)

    def _make_ready(self) -> Steps[None]:
        """A fault of the valve's own is reset, and the valve is in HOLD: the first write can make it ACTIVE."""
        yield from self._leave_fault()
        if not (yield from self._reach(frozenset((ValveState.HOLD,)), ValveState.HOLD, ACTIVATE_S)):
            raise self._error("the valve did not follow", self.state.name, "HOLD", next_step="Read the valve's fault memory.")

    def _command(self, values: Sequence[float]) -> None:
        self._send_command(ValveState.ACTIVE, round(FULL_SPOOL * min(max(values[0], -1.0), 1.0)))

    def _send_safe_command(self) -> None:
        self._send_command(self._safe_state, 0)

    def _is_right(self) -> bool:
        return self.state is ValveState.ACTIVE and not self._is_silent

    def _is_safe(self) -> bool:
        return self.state in SAFE

    def _trouble(self) -> str:
        return "the valve is silent" if self._is_silent else f"the valve is in state {self.state.name}"

    def _on_process_data(self, data: bytearray, stamp_ns: int) -> None:
        if len(data) != _STATUS.size:
            self.malformed += 1
            return
        status, self._spool.raw = _STATUS.unpack(data)
        self._status.raw = status
        self.state = state_of(status)
        self._spool.stamp_ns = self._status.stamp_ns = stamp_ns
        self._accept(stamp_ns)

    def _assess(self) -> None:
        quality = self._frame_quality()
        if self.state in FAULTS or self.state is ValveState.UNKNOWN or (self._active and self.state is not ValveState.ACTIVE):
            quality = Quality.BAD
        self._spool.quality = self._status.quality = quality

    def _send_command(self, wanted: ValveState, set_point: int, bits: int = 0) -> None:
        _COMMAND.pack_into(self._message.data, 0, control_word(self.state, wanted) | bits, set_point)
        self._opened().send(self._message)

    def _reach(self, goals: frozenset[ValveState], wanted: ValveState, limit_s: float, bits: int = 0) -> Steps[bool]:
        """Talk to the valve until it says that it is in one of `goals`; False when it does not get there."""
        return self._answers(lambda: self.state in goals, limit_s, lambda: self._send_command(wanted, 0, bits))

    def _leave_fault(self) -> Steps[None]:
        """One reset: bit R low, then high. A fault that is still there stays, and the caller sees it."""
        if not (yield from self._reach(frozenset(ValveState), ValveState.DISABLED, ACTIVATE_S)):
            raise self._error("the valve is silent", next_step="Check its supply and cable.")
        if self.state in FAULTS:
            yield from self._reach(frozenset(ValveState) - FAULTS, ValveState.DISABLED, ACTIVATE_S, RESET)

    def _prove(self, silence: Silence) -> Steps[ProofResult]:
        name = f"{self.name}: spool safe after {silence}"
        limit_s = self._timeout_s + REACTION_S
        set_point = round(FULL_SPOOL * self._valve.proof_spool)
        wanted = ValveState.ACTIVE if set_point else self._safe_state
        yield from self._leave_fault()
        if (yield from self._answers(lambda: self._has_opened(wanted), OPEN_S, lambda: self._send_command(wanted, set_point))):
            took_s = yield from self._fall_silent(silence, self._has_reacted, limit_s, lambda: self._send_command(wanted, set_point))
            result = proof(name, took_s, limit_s, self._seen())
        else:
            result = not_proven(name, limit_s, f"the spool did not open to {100 * self._valve.proof_spool:g} % ({self._seen()})")
        yield from self._end_proof()
        return result

    def _has_opened(self, wanted: ValveState) -> bool:
        return self.state is wanted and (not self._valve.proof_spool or self._spool_is_at(self._valve.proof_spool))

    def _has_reacted(self) -> bool:
        """In a fault state, and the spool where that state puts it."""
        if self.state not in FAULTS or self.state is ValveState.FAULT_REACTION:
            return False
        return self._spool_is_at(self._valve.failsafe_spool if self.state in FAILSAFE else self._valve.hold_spool)

    def _spool_is_at(self, opening: float) -> bool:
        return abs(self._spool.raw / FULL_SPOOL - opening) <= self._valve.spool_tolerance

    def _end_proof(self) -> Steps[None]:
        yield from self._leave_fault()
        if not (yield from self._reach(SAFE - FAULTS, self._safe_state, ACTIVATE_S)):
            raise self._error("the valve did not return to its safe state after the proof", self.state.name, self._safe_state.name)

    def _seen(self) -> str:
        return f"state {self.state.name}, spool {100 * self._spool.raw / FULL_SPOOL:.1f} %"
