"""Faults of devices and buses, injected where they live: in the twin's CANopen nodes and Modbus unit, on its bus, and in the daemon as a
whole, where what counts is the devices' own supervision.
"""

from __future__ import annotations

from collections.abc import Iterator
from signal import SIGCONT, SIGKILL, SIGSTOP

from daemon.faults.benches.daemon_process import wait_for
from daemon.faults.benches.twin_bench import After, Inject, TwinBench, twin_trial
from daemon.faults.fault import SEEN_MS, Expected, Fault, FaultPlace, Until

DEVICE_TIMEOUT_MS = 100.0  # the devices' own time-out of 60 ms, their own sampling period, and the spool's travel
GAUGE_MS = 100.0  # the poll of the I/O process (50 ms), and the answer it waits for (20 ms)
SILENT_GAUGE_MS = 300.0  # max_age of the pressures (200 ms), and a poll
PAUSE_LIMIT_MS = 50.0  # loop.overruns.fault_late
_GAUGES = "hydraulic_unit"
_ENDED = "nobody is left"


def twin_faults(bench: TwinBench) -> Iterator[Fault]:
    yield from _encoder_faults(bench)
    yield from _valve_faults(bench)
    yield from _gauge_faults(bench)
    yield from _bus_faults(bench)
    yield from _host_faults(bench)


def _fault(
    bench: TwinBench,
    name: str,
    group: str,
    expected: Expected,
    inject: Inject,
    after: After = TwinBench.reaction,
    reusable: bool = True,
) -> Fault:
    run = twin_trial(bench, inject, expected.until, 2.0 * expected.limit_ms + 1000.0, after, reusable)
    return Fault(f"CAN: {name}", group, expected, run, where=FaultPlace.TWIN, impossible=bench.impossible)


def _device(device: str, fault: str, amount: float = 0.0) -> Inject:
    return lambda bench: bench.twin.inject(device, fault, amount)


def _encoder_faults(bench: TwinBench) -> Iterator[Fault]:
    for joint in ("rotary", "prismatic"):
        encoder = f"{joint}_encoder"

        def fault(name: str, expected: str, inject: Inject, joint: str = joint) -> Fault:
            return _fault(bench, f"{joint} encoder {name}", "encoder", Expected(f"fault: {joint}{expected}", Until.SAFE, SEEN_MS), inject)

        yield fault("off", ".position quality", _device(encoder, "silent"))
        yield fault("alarm bit", ".position quality", _device(encoder, "alarm", 1))
        yield fault("jumps 200 counts", " position rate", _device(encoder, "jump", 200))
        yield fault("noisy, 12 counts rms", " position", _device(encoder, "noisy", 12))
        yield fault("late by 30 ms", ".position", _device(encoder, "late", 30))
    yield from _rotary_encoder_faults(bench)


def _rotary_encoder_faults(bench: TwinBench) -> Iterator[Fault]:
    """What one encoder shows for both."""

    def fault(name: str, expected: str, inject: Inject, reusable: bool = True) -> Fault:
        return _fault(bench, f"rotary encoder {name}", "encoder", Expected(expected, Until.SAFE, SEEN_MS), inject, reusable=reusable)

    yield fault("stuck", "fault: rotary ", _device("rotary_encoder", "stuck"))  # "stuck" or "unexplained motion"
    leaves = _device("rotary_encoder", "leave")
    yield fault("leaves OPERATIONAL", "fault: ", leaves, reusable=False)  # missing frames or heartbeat, whichever is seen first
    yield fault("restarts", "fault: a device refused read", _device("rotary_encoder", "restart"), reusable=False)
    warned = _device("rotary_encoder", "emcy", 0x1000)
    yield _fault(bench, "rotary encoder EMCY", "encoder", Expected("none: the run goes on", Until.RENEWED, PAUSE_LIMIT_MS), warned)


def _valve_faults(bench: TwinBench) -> Iterator[Fault]:
    refused = "fault: a device refused write"

    def fault(name: str, expected: str, limit_ms: float, inject: Inject, reusable: bool = True) -> Fault:
        return _fault(bench, f"rotary valve {name}", "valve", Expected(expected, Until.SAFE, limit_ms), inject, reusable=reusable)

    yield fault("off", f"device time-out; {refused}", DEVICE_TIMEOUT_MS, _device("rotary_valve", "silent"))
    yield fault("EMCY and device fault", "fault: a device refused", SEEN_MS, _device("rotary_valve", "device_fault"), reusable=False)
    yield fault("leaves ACTIVE by itself", refused, SEEN_MS, _device("rotary_valve", "wrong_state"))
    yield fault("leaves OPERATIONAL", "fault: a device refused", SEEN_MS, _device("rotary_valve", "leave"), reusable=False)
    yield fault("restarts", "fault: a device refused read", SEEN_MS, _device("rotary_valve", "restart"), reusable=False)


def _gauge_faults(bench: TwinBench) -> Iterator[Fault]:
    def fault(name: str, expected: str, limit_ms: float, inject: Inject) -> Fault:
        return _fault(bench, name, "Modbus", Expected(expected, Until.SAFE, limit_ms), inject)

    yield fault("Modbus unit dead", "fault: ", SILENT_GAUGE_MS, _device(_GAUGES, "dead"))
    yield fault("Modbus black hole", "fault: ", GAUGE_MS, _device(_GAUGES, "black_hole"))
    yield fault("Modbus slow, 100 ms", "fault: ", GAUGE_MS, _device(_GAUGES, "slow", 100))
    yield fault("Modbus exception 4", "fault: ", GAUGE_MS, _device(_GAUGES, "exception", 4))
    yield fault("Modbus wrong value", "fault: ", GAUGE_MS, _device(_GAUGES, "jump", 3000))
    lost = _device("plant", "supply_pressure", 0.0)  # seen by the gauge, or by the arm that no longer follows
    yield fault("supply pressure lost", "fault: rotary", GAUGE_MS, lost)


def _bus_faults(bench: TwinBench) -> Iterator[Fault]:
    silent = "device time-out; fault: "  # whichever comes first: missing frames or the bus's own error
    yield _fault(bench, "bus off", "bus", Expected(silent, Until.SAFE, DEVICE_TIMEOUT_MS), _device("bus", "bus_off"))
    yield _fault(bench, "bus full of foreign frames", "bus", Expected(silent, Until.SAFE, DEVICE_TIMEOUT_MS), _device("bus", "flood", 8000))
    yield _fault(
        bench, "send queue full (ENOBUFS)", "bus", Expected(silent, Until.SAFE, DEVICE_TIMEOUT_MS), lambda bench: bench.fill_send_queue()
    )
    busy = _device("bus", "flood", 2000)
    yield _fault(bench, "2000 foreign frames a second", "bus", Expected("none: the run goes on", Until.RENEWED, PAUSE_LIMIT_MS), busy)


def _host_faults(bench: TwinBench) -> Iterator[Fault]:
    def fault(name: str, expected: str, inject: Inject, after: After, reusable: bool = False) -> Fault:
        return _fault(
            bench,
            name,
            "host",
            Expected(f"device time-out; {expected}", Until.SAFE, DEVICE_TIMEOUT_MS),
            inject,
            after=after,
            reusable=reusable,
        )

    yield fault("control SIGKILLed", "the daemon ends with status 1", lambda bench: bench.signal(SIGKILL, "control"), _end)
    yield fault("control SIGSTOPped", "fault: ", lambda bench: bench.signal(SIGSTOP, "control"), _continued, reusable=True)
    everybody = ("control", "supervisor", "recorder", "io")  # a process that outlives the control process for a moment cannot act
    yield fault("host dies (all processes SIGKILLed)", _ENDED, lambda bench: bench.signal(SIGKILL, *everybody), lambda bench: _ENDED)


def _end(bench: TwinBench) -> str:
    wait_for(lambda: bench.daemon.exit_status() is not None)
    return f"the daemon ends with status {bench.daemon.exit_status()}"


def _continued(bench: TwinBench) -> str:
    """Continue the process; the arm must not move on."""
    bench.signal(SIGCONT, "control")
    wait_for(lambda: bench.client.call("status")["mode"] == "fault")
    return bench.reaction()
