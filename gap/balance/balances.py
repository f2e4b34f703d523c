"""The balance equations of a rig, formed from what was measured: whichever does not come out even is where the model is wrong.

An equation is formed only where every quantity in it is measured or known from the rig file: the force balance of an axis needs its drive
force (chamber pressures, or the command of an electric drive), a chamber's flow balance its pressure, the bending of the link its tip.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from config.schema.rig import Rig
from gap.balance.flow_balance import flow_balance
from gap.balance.force_balance import force_balance
from gap.balance.link_bending import link_bending
from gap.balance.log_signals import LogSignals, log_signals
from gap.balance.weak_form import LEAST_ROWS, bump
from gap.data.measured import Array, Measured
from sim_backend.memory.layout import J_START, J_STRIDE, C, J, Kind

SPANS_S = (0.05, 0.1, 0.2, 0.4)  # supports tried: the shortest in which noise stays small against the terms of the equation
QUIET = 0.05  # share of an equation's terms
KNOWN = 0.05  # relative accuracy of the constants: terms this much smaller than the largest decide nothing


@dataclass(frozen=True, slots=True)
class Balance:
    """One equation over one log. `rows`: middle of every support; `residual`: mean imbalance there; `sd`: what noise and the constants'
    own uncertainty make of it. All in `unit`."""

    equation: str
    where: str
    unit: str
    rows: Array
    residual: Array
    sd: Array

    @property
    def z(self) -> float:
        """Root mean square of the imbalance in standard deviations: about 1 or less for an equation that holds."""
        return float(np.sqrt(np.mean((self.residual / self.sd) ** 2))) if self.residual.size else 0.0


def balances(log: Measured, rig: Rig, sigma: Mapping[str, float]) -> list[Balance]:
    """Every equation that can be formed on this log, most violated first. `sigma`: noise of each channel."""
    signals = log_signals(log, rig, sigma)
    found = [balance for formed in _formers(signals) if (balance := _shortest(signals, *formed)) is not None]
    return sorted(found, key=lambda balance: -balance.z)


def obstacles(log: Measured, rig: Rig) -> dict[str, str]:
    """Joint → why its force balance cannot be formed on this log; without the joints for which it can."""
    signals = log_signals(log, rig, {})
    return {joint: why for joint in rig.joints if (why := _obstacle(signals, joint))}


def _formers(log: LogSignals) -> Iterator[tuple[str, str, str]]:
    """Equation, place and unit of everything that can be formed."""
    arm = log.p[C.ARM] > 0.0
    for joint, slot in log.slots.items():
        j = J_START + slot * J_STRIDE
        kind, force = log.p[j + J.KIND], "N*m" if slot == 0 else "N"
        pressures = [name for name in ("pressure_a", "pressure_b") if f"{joint}.{name}" in log.signals]
        if not _obstacle(log, joint):
            yield "force balance", joint, force
        if kind == Kind.HYDRAULIC:
            for name in pressures:
                yield "chamber flow balance", f"{joint}.{name}", "m^3/s"
    if arm and "tip.deflection" in log.signals and log.p[C.GRAVITY] == 0.0:
        yield "link bending", "link", "N" if log.p[C.BENDING_STIFFNESS] > 0.0 else "m"


def _obstacle(log: LogSignals, joint: str) -> str:
    """Why the force balance of a joint cannot be formed; empty when it can."""
    j = J_START + log.slots[joint] * J_STRIDE
    kind = log.p[j + J.KIND]
    needed = {Kind.HYDRAULIC: ("pressure_a", "pressure_b"), Kind.IMPOSED: ("pressure_a",)}.get(Kind(int(kind)), ())
    lacking = [f"{joint}.{name}" for name in needed if f"{joint}.{name}" not in log.signals]
    if lacking:
        return f"the drive's force is not known without {' and '.join(lacking)}"
    if log.p[C.ARM] > 0.0 and log.p[C.GRAVITY] != 0.0:
        return "the arm is tilted"
    return "backlash lies between the drive and the load" if log.p[j + J.GAP] != 0.0 else ""


def _shortest(log: LogSignals, equation: str, where: str, unit: str) -> Balance | None:
    """The equation on the shortest supports on which noise does not drown it."""
    form = {"force balance": force_balance, "chamber flow balance": flow_balance, "link bending": link_bending}[equation]
    rows_in_all = len(next(iter(log.signals.values())))
    found = None
    for span_s in SPANS_S:
        rows = max(round(span_s / log.period_s), LEAST_ROWS)
        starts: NDArray[np.int64] = np.arange(0, rows_in_all - rows, max(rows // 2, 1), dtype=np.int64)
        if starts.size < 4:
            break
        done, moving = form(log, where, bump(rows, log.period_s), starts)
        good = np.isfinite(done.total) & moving
        if good.sum() < 4:
            continue
        size = float(np.sqrt(np.mean(done.largest[good] ** 2)))
        noise = np.sqrt(done.variance)[good]
        place = where.partition(".")[0]
        found = Balance(equation, place, unit, starts[good] + rows // 2, done.total[good], np.hypot(noise, KNOWN * max(size, 1e-300)))
        if float(np.median(noise)) <= QUIET * size:
            break
    return found
