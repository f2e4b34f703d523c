"""A simulated servovalve (CiA 408): device control, spool set point, fault reactions. ±16384 counts are ±100 % opening.

Where the spool goes: to the set point in ACTIVE with device mode 1, to the hold set point in HOLD and FAULT_HOLD, else to the
hydraulic fail-safe position. It gets there within its stroke time; the plant is told the demand and has a spool of its own.
"""

from __future__ import annotations

from collections.abc import Sequence

from sim_backend.twin.can.can_node import HEARTBEAT_LOST, CanNode
from sim_backend.twin.can.object_store import Send
from sim_backend.twin.can.valve_states import ValveState, commanded, faulted

CONTROL, STATUS, DEVICE_MODE = (0x6040, 0), (0x6041, 0), (0x6042, 0)
SET_POINT, ACTUAL, HOLD_SET_POINT = (0x6300, 1), (0x6301, 1), (0x6314, 1)
FAULT_REACTION = 0x2830
FULL_SCALE = 16384
ARRIVED_COUNTS = FULL_SCALE // 100
_SET_POINT_BY_BUS = 1
_DEFAULT_REACTION = 2


class Valve(CanNode):
    """`reaction_subs`: which entries of 0x2830 stand for a lost heartbeat and for late set points (the manufacturer's choice; the
    last is taken for both when there is one only). `safe_since_ns` is when the spool arrived where the device itself wants it; None
    while it follows the set point or is on its way.
    """

    profile = "valve_408"

    def __init__(self, name: str, node: int, send: Send, reaction_subs: Sequence[int] = (), failsafe: float = 0.0, stroke_s: float = 0.01):
        self._reaction_subs = tuple(reaction_subs)
        self._failsafe_counts = round(FULL_SCALE * failsafe)
        self._counts_per_s = FULL_SCALE / stroke_s
        self.device_state = ValveState.NOT_READY
        self.safe_since_ns: int | None = 0
        self._old_control = 0
        self._spool = float(self._failsafe_counts)
        super().__init__(name, node, send)

    def powered_on(self) -> None:
        self._old_control = 0
        self._go(ValveState.INIT)

    def received(self) -> None:
        word = self.store.values[CONTROL]
        self._go(commanded(self.device_state, word, self._old_control))
        self._old_control = word

    def object_written(self, index: int) -> None:
        if index == CONTROL[0]:
            self.received()

    def communication_lost(self, code: int) -> None:
        self._fault(self._reaction_subs[:1] if code == HEARTBEAT_LOST else self._reaction_subs[-1:])

    def left_operational(self) -> None:
        """CiA 408 leaves this open. Here an ACTIVE valve takes it for a loss of communication, as no set point can come any more."""
        if self.device_state is ValveState.ACTIVE:
            self._fault(self._reaction_subs[-1:])

    def inject(self, fault: str, amount: float) -> None:
        """Also: `wrong_state` (leaves ACTIVE by itself for DISABLED, whatever it is told) and `device_fault`."""
        if fault == "wrong_state":
            self._go(ValveState.DISABLED)
            self._old_control = self.store.values[CONTROL] = 0
            self.faults.stuck_state = True
        elif fault == "device_fault":
            self.emergency(0x5000)
            self._fault(())
        else:
            super().inject(fault, amount)

    @property
    def demand_counts(self) -> int:
        """What the spool is to do, in counts."""
        values = self.store.values
        if self.device_state is ValveState.ACTIVE and values[DEVICE_MODE] == _SET_POINT_BY_BUS:
            return max(-FULL_SCALE, min(FULL_SCALE, values[SET_POINT]))
        if self.device_state in (ValveState.HOLD, ValveState.FAULT_HOLD, ValveState.FAULT_REACTION):
            return values[HOLD_SET_POINT]
        return self._failsafe_counts

    def move(self, period_s: float, now_ns: int) -> float:
        """One plant period: the spool moves. Returns the demand as a share of the full opening, for the plant."""
        demand = self.demand_counts
        step = self._counts_per_s * period_s
        if not self.faults.stuck:
            self._spool += max(-step, min(step, demand - self._spool))
            shown = round(self.faults.measured(self._spool))
            self.store.values[ACTUAL] = max(-32768, min(32767, shown))
        is_safe = self.device_state is not ValveState.ACTIVE and abs(self._spool - demand) <= ARRIVED_COUNTS
        if not is_safe:
            self.safe_since_ns = None
        elif self.safe_since_ns is None:
            self.safe_since_ns = now_ns
        return (self._spool if self.faults.stuck else demand) / FULL_SCALE

    def describe(self) -> dict[str, float | str]:
        demand, spool = self.demand_counts / FULL_SCALE, self._spool / FULL_SCALE
        safe = {"safe_since_ns": self.safe_since_ns} if self.safe_since_ns is not None else {}
        return super().describe() | {"state": self.device_state.name, "demand": demand, "spool": spool, **safe}

    def _fault(self, subs: Sequence[int]) -> None:
        reaction = self.store.values.get((FAULT_REACTION, subs[0]), _DEFAULT_REACTION) if subs else _DEFAULT_REACTION
        self._go(faulted(self.device_state, reaction))

    def _go(self, state: ValveState) -> None:
        if self.faults.stuck_state:
            return
        self.device_state = state
        self.store.values[STATUS] = state.status_bits
