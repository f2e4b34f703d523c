"""The answer to `status`, made from the facts the loop publishes."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from typing import Any

from config.options.canopen_rig import proofs
from config.schema.rig import Rig
from daemon.checks.interlocks import rest_checks
from daemon.checks.link_watch import LinksView
from daemon.cycle.facts import Facts
from daemon.cycle.timing import Timing
from daemon.server.event_history import EventHistory, RunResult
from recording.format.fields import field_of_signal
from recording.format.layout import CycleLayout
from servo_control.link.kinematics import forward
from servo_control.signals import Mode

_JOINT_WORDS = ("position", "target", "reference", "velocity", "command_V")


class StatusView:
    """`status` of one rig. `values` may be empty before the loop has published anything."""

    def __init__(self, rig: Rig, facts: Facts, timing: Timing) -> None:
        self._rig, self._facts, self._timing = rig, facts, timing
        self._rest_checks = rest_checks(rig, facts)
        self._proofs, self._links, self._readings = proofs(rig), LinksView(rig, facts.indices), read_signals(rig)
        self._values: Sequence[float] = facts.blank()

    def status(self, values: Sequence[float], uptime_s: float, history: EventHistory) -> dict[str, Any]:
        """As docs/reference/protocol.md describes it; a number that is not known is NaN (null on the wire)."""
        self._values = values
        mode = self.mode(values)
        return {
            "rig": self._rig.name,
            "mode": mode.name.lower(),
            "cycle": int(self._fact("cycle")),
            "t_s": self._fact("t_s"),
            "clock": "wall",
            "uptime_s": uptime_s,
            "estop": "latched" if self._fact("estop_latched") else "released",
            "run": self._run(history.last_run),
            "joints": {name: self._joint(name, joint.position_unit) for name, joint in self._rig.joints.items()},
            "tip": self._tip(),
            "supply": {name: self._supply(name) for name in self._rig.joints},
            "reservoir_temperature_C": self._fact("reservoir_temperature_C"),
            "readings": {name: {"value": self._fact(field), "unit": unit} for name, (field, unit) in self._readings.items()},
            "safe_state": {
                name: {"demanded": demanded, "proven_s": self._fact(f"{name}.proven_s")} for name, demanded in self._proofs.items()
            },
            "at_rest": [check.row(values) for check in self._rest_checks],
            "links": self._links.status(values),
            "loop": self._loop(),
            "fault": history.fault if mode is Mode.FAULT else None,
        }

    def mode(self, values: Sequence[float]) -> Mode:
        return Mode(int(values[self._facts.index("mode")]))

    def _fact(self, name: str) -> float:
        return self._values[self._facts.index(name)] if self._facts.has(name) else nan

    def _run(self, run: RunResult | None) -> dict[str, Any] | None:
        if run is None:
            return None
        segment = int(self._fact("segment"))
        name = run.segments[segment - 1][0] if 0 < segment <= len(run.segments) else ""
        return {
            "run": run.run,
            "maneuver": run.maneuver,
            "shaper": run.shaper,
            "segment": segment,
            "segment_name": name,
            "elapsed_s": self._fact("run.elapsed_s"),
            "duration_s": self._fact("run.duration_s"),
            "countdown_s": self._fact("run.countdown_s"),
            "validity": run.validity,
            "reason": run.reason,
        }

    def _joint(self, name: str, unit: str) -> dict[str, Any]:
        return {word: self._fact(f"{name}.{word}") for word in _JOINT_WORDS} | {"unit": unit}

    def _tip(self) -> dict[str, float]:
        """x and y of the rigid arm's tip in the paper's frame (arm along +Y at rotary 0), and what the tip sensors say."""
        tip = {"deflection_m": self._fact("tip.deflection_m"), "acceleration_mps2": self._fact("tip.acceleration_mps2")}
        if self._rig.arm.kind == "rotary_prismatic":
            rotary, extension = self._fact("rotary.position"), self._fact("prismatic.position")
            tip["x_m"], tip["y_m"] = forward(rotary, extension, self._rig.arm.hub_offset_m)
        return tip

    def _supply(self, joint: str) -> dict[str, float]:
        names = ("supply_pressure_Pa", "return_pressure_Pa", "supply_temperature_C", "return_temperature_C")
        return {name: self._fact(f"{joint}.{name}") for name in names}

    def _loop(self) -> dict[str, Any]:
        timing = self._timing
        return {
            "rate_Hz": self._rig.loop.rate_Hz,
            "overruns": int(self._fact("overruns")),
            "drops": int(self._fact("drops")),
            "late_us_p50": timing.percentile_us("late", 50.0),
            "late_us_p99": timing.percentile_us("late", 99.0),
            "phases": {
                name: {
                    "p50_us": timing.percentile_us(name, 50.0),
                    "p99_us": timing.percentile_us(name, 99.0),
                    "max_us": timing.largest_us(name),
                }
                for name in ("read", "compute", "write", "work")
            },
        }


def read_signals(rig: Rig) -> dict[str, tuple[str, str]]:
    """Every signal that the rig's drivers measure, in the order of its file: the field of the log that holds it, and its SI unit."""
    units = {field.name: field.unit for field in CycleLayout.of_rig(rig).fields}
    return {name: (field_of_signal(name), units[field_of_signal(name)]) for name in rig.signals}
