"""Faults of drivers and of the loop's own time, and what an operator asks for."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from daemon.faults.benches.lockstep_bench import Inject, LockstepTarget, loaded_rig, lockstep_trial
from daemon.faults.fault import SEEN_MS, Expected, Fault, Until
from daemon.faults.sensor_faults import STOP_MS
from daemon.modes.mode_machine import OperatorAction

LONG_STALL_MS = 100.0
DEVICE_MARGIN_MS = 10.0  # a period of the loop, and this program's own sampling


def device_limit_ms() -> float:
    """Without any more writes: the device's own time-out."""
    return max(device.timeout_s for device in loaded_rig().rig.devices.values()) * 1e3 + DEVICE_MARGIN_MS


def loop_faults() -> Iterator[Fault]:
    yield from _driver_faults()
    yield from _stalls()
    yield _fault("e-stop", "operator", "fault: e-stop", Until.SAFE, SEEN_MS, _post(OperatorAction.ESTOP))
    yield _fault("operator disarms in motion", "operator", "disarmed", Until.SAFE, SEEN_MS, _post(OperatorAction.DISARM))
    yield _fault("operator stop", "operator", "controlled stop", Until.REST, STOP_MS, _post(OperatorAction.STOP))
    yield _fault("e-stop while the device refuses to be safe", "operator", "fault: e-stop", Until.SAFE, device_limit_ms(), _unsafe_estop)


def _driver_faults() -> Iterator[Fault]:
    yield _fault("driver raises in read", "driver", "fault: a device refused read", Until.SAFE, SEEN_MS, _raise_in("read"))
    yield _fault("driver raises in write", "driver", "fault: a device refused write", Until.SAFE, SEEN_MS, _raise_in("write"))
    yield _fault(
        "driver raises in read and in safe", "driver", "fault: a device refused", Until.SAFE, device_limit_ms(), _raise_in("read", "safe")
    )
    yield _fault("driver raises once in read", "driver", "fault: a device refused read", Until.SAFE, SEEN_MS, _raise_once)


def _stalls() -> Iterator[Fault]:
    overruns = loaded_rig().rig.loop.overruns
    patience_ms, goes_on = overruns.fault_late_s * 1e3, "counted as overrun"
    yield _fault("loop stalled 5 ms", "loop", goes_on, Until.RENEWED, SEEN_MS, _stall_once(5.0))
    yield _fault("loop stalled 20 ms", "loop", goes_on, Until.RENEWED, patience_ms, _stall_once(20.0))
    # The valves time out meanwhile; but the cycle that was held up still writes, and the next one finds the stall.
    stalled = _stall_once(LONG_STALL_MS)
    yield _fault("loop stalled 100 ms", "loop", "fault: loop stall", Until.SAFE, LONG_STALL_MS + DEVICE_MARGIN_MS, stalled)
    limit_ms = STOP_MS + overruns.window_s * 1e3
    yield _fault("loop late in every cycle", "loop", "", Until.REST, limit_ms, _stall_always(1.5))


def _fault(name: str, group: str, expected: str, until: Until, limit_ms: float, inject: Inject) -> Fault:
    return Fault(name, group, Expected(expected, until, limit_ms), lockstep_trial(inject, until, "rotary"))


def _post(action: OperatorAction) -> Inject:
    return lambda target: target.rig.post(action)


def _raise_in(*verbs: str) -> Inject:
    def inject(target: LockstepTarget) -> None:
        target.device.before |= dict.fromkeys(verbs, _refuse)

    return inject


def _refuse() -> None:
    raise OSError("the device does not answer")


def _raise_once(target: LockstepTarget) -> None:
    def refuse_once() -> None:
        del target.device.before["read"]
        _refuse()

    target.device.before["read"] = refuse_once


def _unsafe_estop(target: LockstepTarget) -> None:
    target.device.before["safe"] = _refuse
    target.rig.post(OperatorAction.ESTOP)


def _stall_once(length_ms: float) -> Inject:
    def inject(target: LockstepTarget) -> None:
        def stall() -> None:
            del target.device.before["read"]
            target.stall(length_ms)

        target.device.before["read"] = stall

    return inject


def _stall_always(length_ms: float) -> Inject:
    def always(target: LockstepTarget) -> Callable[[], None]:
        return lambda: target.stall(length_ms)

    def inject(target: LockstepTarget) -> None:
        target.device.before["read"] = always(target)

    return inject
