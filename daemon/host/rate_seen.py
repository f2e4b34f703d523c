"""What the log of a daemon says of this computer at one rate: how late the loop woke up, how long it worked, whether it keeps the rate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from config.schema.rig import Loop

MEASURED_S = 2.0
MARGIN = 0.5  # of what the rig allows: seconds see less than a minute
_WORK = ("read_us", "compute_us", "write_us")


@dataclass(frozen=True, slots=True)
class RateSeen:
    """`late_…_s`: after its deadline a cycle began; `work_p99_s`: its reading, computing and writing together; `in_window`: most overruns
    within the rig's window; `largest_s`: how late a cycle ended at most; `lost`: cycles absent from the log; `held`: with an armed
    controller on simulated devices, else with safe outputs; `refused`: what the operating system did not grant. The last three: the
    rig's `loop.overruns`.
    """

    rate_Hz: float
    held: bool
    cycles: int
    late_p50_s: float
    late_p99_s: float
    late_p999_s: float
    work_p99_s: float
    largest_s: float
    overruns: int
    in_window: int
    lost: int
    refused: tuple[str, ...]
    window_s: float
    stop_after: int
    fault_late_s: float

    @property
    def keeps_rate(self) -> bool:
        """A window that is longer than what was seen holds as many overruns more."""
        expected = self.in_window * max(1.0, self.window_s * self.rate_Hz / max(self.cycles, 1))
        return not self.lost and expected < MARGIN * self.stop_after and self.largest_s < MARGIN * self.fault_late_s

    def text(self) -> str:
        """What was measured, and what the rig allows; in a second line what the operating system refused."""
        return (
            f"{self.cycles} cycles at {self.rate_Hz:.0f} Hz: 99 % began at most {max(self.late_p99_s * 1e6, 1.0):.0f} µs late; "
            f"{self.overruns} overruns, {self.in_window} of them within {self.window_s:g} s (a run stops at {self.stop_after}); at most "
            f"{self.largest_s * 1e3:.1f} ms late (a fault at {self.fault_late_s * 1e3:.0f} ms)"
            + (f"; {self.lost} cycles are absent from the log" if self.lost else "")
            + ("\n  refused by the operating system: " + "; ".join(self.refused) if self.refused else "")
        )


def rate_seen(columns: Mapping[str, Any], loop: Loop, rate_Hz: float, held: bool, refused: tuple[str, ...]) -> RateSeen:
    """`columns`: of the log's cycles, in their order (at least two); `loop`: the rig's, whose limits count whatever the measurement had."""
    over, begun_s = loop.overruns, columns["t_s"]
    late_s, work_s = 1e-6 * columns["late_us"], 1e-6 * sum(columns[name] for name in _WORK)
    # A cycle that ended late makes the next one begin late, and skips those whose time had passed.
    ended_late_s = np.diff(begun_s) - 1.0 / rate_Hz + late_s[1:]
    total = columns["overruns"].astype(int)
    before = np.searchsorted(begun_s, begun_s - over.window_s)
    p50, p99, p999 = (float(share) for share in np.quantile(late_s, (0.5, 0.99, 0.999)))
    return RateSeen(
        rate_Hz=rate_Hz,
        held=held,
        cycles=len(begun_s),
        late_p50_s=p50,
        late_p99_s=p99,
        late_p999_s=p999,
        work_p99_s=float(np.quantile(work_s, 0.99)),
        largest_s=max(float(ended_late_s.max()), 0.0),
        overruns=int(total[-1] - total[0]),
        in_window=int((total - total[before]).max()),
        lost=int(columns["cycle"][-1] - columns["cycle"][0] + 1 - len(begun_s)),
        refused=refused,
        window_s=over.window_s,
        stop_after=over.stop_after,
        fault_late_s=over.fault_late_s,
    )
