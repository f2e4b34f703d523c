"""What every step of a commissioning is given."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from config.errors import DaemonError
from config.loading.load import LoadedRig
from config.loading.stated_units import conversions, stated_units
from config.schema.rig import Rig
from config.stated_sentences import Conversion
from daemon.checks.declared.daemon_health import RECORDER_SILENT, STALL, TIMING
from daemon.cli.commission.bench import Bench, Ran
from daemon.cli.commission.record import StepRecord
from daemon.modes.run_watch import MISSED
from tuning.experiments.experiments import What

AGAIN = 2  # times that a run is made again, which something late has ended
_LATE = (STALL.name, TIMING.name, RECORDER_SILENT.name)
_LATE_SIGNAL = (" age", " quality")  # a device whose frames stay away has samples of bad quality


@dataclass
class Context:
    """`ask` puts a question to the operator and answers whether he said yes; `say` tells him what happens. `records`: what the steps so
    far left, those of earlier sessions too."""

    loaded: LoadedRig
    bench: Bench
    folder: Path
    ask: Callable[[str], bool]
    say: Callable[[str], None]
    maneuver: str = ""
    shaper: str = "adaptive"
    effort: int = 25
    identify: What = "map"
    by: str = ""
    records: Mapping[str, StepRecord] = field(default_factory=dict)

    @property
    def rig(self) -> Rig:
        return self.loaded.rig

    @property
    def logs(self) -> Path:
        return self.folder / "logs"

    @cached_property
    def _units(self) -> dict[str, str]:
        return stated_units(self.loaded.text)

    def shown(self, value: float, unit: str, owner: str, digits: int = 4) -> str:
        """An SI number of a signal or joint as the rig file states it. A difference, such as noise, is one of `unit` without offset."""
        return self._text(value, unit, owner, digits, offset=True)

    def shown_difference(self, value: float, unit: str, owner: str, digits: int = 3) -> str:
        return self._text(value, unit, owner, digits, offset=False)

    def _text(self, value: float, unit: str, owner: str, digits: int, offset: bool) -> str:
        stated: Conversion = conversions({owner: unit}, self._units).get(owner, (unit, 1.0, 0.0))
        number = stated[1] * value + stated[2] * offset
        return f"{number:.{digits}g} {stated[0]}".strip() if math.isfinite(number) else "no value"

    def allow(self, what: str) -> None:
        """Ask before motion. DaemonError when the operator says no: nothing has moved then."""
        if not self.ask(f"{what}. Go on?"):
            raise DaemonError("not allowed by the operator", value=what, next_step="Start `longreach commission` again when it may move.")

    def run(self, request: Mapping[str, Any], stop_after_s: float | None = None) -> Ran:
        """Arm, run, disarm. A run that this computer or a device was too late for is made again, if the operator allows it."""
        ran = self.bench.run(request, stop_after_s)
        for left in range(AGAIN, 0, -1):
            if ran.valid or not _late(ran.reason):
                break
            self.say(f"   not valid: {ran.reason}")
            if not self.ask(f"Something was late. The same run is made again, {left} times at most. Go on?"):
                break
            if ran.mode == "fault":
                self.bench.act("reset")
            ran = self.bench.run(request, stop_after_s)
        return ran


def _late(reason: str) -> bool:
    """Whether a run ended because this computer did not keep time or a sample came late, as far as its reason says."""
    check = reason.removeprefix("fault: ").partition(" (")[0]
    return check in _LATE or check.endswith(_LATE_SIGNAL) or MISSED in reason
