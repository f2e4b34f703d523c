"""What every step of a commissioning is given."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

from config.errors import DaemonError
from config.loading.load import LoadedRig
from config.loading.stated_units import conversions, stated_units
from config.schema.rig import Rig
from config.stated_sentences import Conversion
from daemon.cli.commission.bench import Bench, Ran
from daemon.cli.commission.late import ended_late, tells_of_lateness
from daemon.cli.commission.record import StepRecord
from daemon.modes.mode_keeper import NOT_HOLDING
from tuning.experiments.experiments import What

Made = TypeVar("Made")
AGAIN = 2  # times that a run or a proof is made again, which something late has ended


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
        return self._again_while_late("run", lambda: self.bench.run(request, stop_after_s), self._late_end)

    def prove(self) -> dict[str, Any]:
        """The proof of the safe state, made again in the same way."""
        return self._again_while_late("proof", self.bench.prove, lambda answer: None)

    def _again_while_late(self, what: str, do: Callable[[], Made], late: Callable[[Made], Ran | None]) -> Made:
        """`late`: the run that something late has ended. A reset also sets devices up anew that have heard nothing for too long."""
        if self.bench.latched:
            self.allow("A fault or the e-stop is latched from before; it is reset")
            self.bench.act("reset")
        for left in range(AGAIN, 0, -1):
            try:
                made = do()
            except DaemonError as refusal:
                why = self._with_fault(str(refusal))
                if not tells_of_lateness(why) or not self._again(why, what, left):
                    raise
                self.bench.act("reset")
                continue
            ended = late(made)
            if ended is None or not self._again(f"not valid: {self._with_fault(ended.reason)}", what, left):
                return made
            if ended.mode == "fault":
                self.bench.act("reset")
        return do()

    def _again(self, why: str, what: str, left: int) -> bool:
        self.say(f"   {why}")
        return self.ask(f"Something was late. The same {what} is made again, {left} times at most. Go on?")

    def _late_end(self, ran: Ran) -> Ran | None:
        late = ended_late(ran.reason) or (NOT_HOLDING in ran.reason and tells_of_lateness(self.bench.fault))
        return ran if not ran.valid and late else None

    def _with_fault(self, reason: str) -> str:
        """With what has latched meanwhile, where the reason does not say it."""
        fault = self.bench.fault
        return reason if not fault or fault in reason else f"{reason} The fault: {fault}"
