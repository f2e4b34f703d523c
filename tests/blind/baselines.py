"""What simpler methods would have said of the same logs: refit only, sparse regression on weak-form residuals, iid BIC without hold-out.

Each balance of a joint is multiplied by bumps φ of 0.25 s and integrated; columns of the library are what each effect adds to it. Columns
of effects that the rig file has, and of its constants, take part unpenalised. No simulation, no memory states: that is the point.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

from config.loading.load import load_rig
from tests.blind.truth.nominal import Numbers, nominal

Array = NDArray[np.float64]
Name = tuple[str, str]
METHODS = {
    "refit": "refit of the constants only (names nothing)",
    "stlsq": "sparse regression (STLSQ) on weak-form residuals",
    "bic": "forward selection by iid BIC on the same, no hold-out",
}
SUPPORT_S, EVERY_S, PERIOD_S = 0.25, 0.05, 0.001
THRESHOLDS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4)  # of the residual's norm
MOST = 4


@dataclass(frozen=True, slots=True)
class Balance:
    """One weak-form balance: residual (n), columns by name (candidates and those that always take part), all n long."""

    residual: Array
    candidates: Mapping[Name, Array]
    always: Array  # n × k


def baselines(rig_path: Path, fit: Path, holdout: Path, result: Mapping[str, Any]) -> dict[str, list[Name]]:
    """Names each method gives, strongest first."""
    loaded = load_rig(rig_path)
    assert loaded.rig.plant is not None
    present = {(entry.effect, entry.where) for entry in loaded.rig.plant.effects}
    numbers = nominal(loaded.rig)
    pairs = zip(balances(numbers, fit, present), balances(numbers, holdout, present), strict=True)
    found = [(stlsq(a, b), forward_bic(a)) for a, b in pairs]
    return {"refit": [], "stlsq": _strongest([f[0] for f in found]), "bic": _strongest([f[1] for f in found])}


def _strongest(parts: Sequence[Sequence[tuple[float, Name]]]) -> list[Name]:
    """Names of all balances by the share of their residual that they explain."""
    return [name for _, name in sorted((item for part in parts for item in part), reverse=True)][:MOST]


def balances(numbers: Numbers, path: Path, present: set[Name]) -> list[Balance]:
    """Rotary and prismatic motion, and the supply pressure."""
    data = np.genfromtxt(path, delimiter=",", names=True, deletechars="")
    columns = {name: np.asarray(data[name], dtype=float) for name in data.dtype.names}
    return [*(_motion(numbers, columns, joint, present) for joint in ("rotary", "prismatic")), _supply(numbers, columns)]


def _weak(signal: Array) -> Array:
    """∫ φ signal dt of every bump."""
    t = np.linspace(-1, 1, round(SUPPORT_S / PERIOD_S))
    bump = (1 - t * t) ** 3
    return np.convolve(signal, bump / bump.sum(), "valid")[:: round(EVERY_S / PERIOD_S)]


def _motion(numbers: Numbers, log: Mapping[str, Array], joint: str, present: set[Name]) -> Balance:
    """Flow balance of a joint, the load pressure measured or from the rigid force balance."""
    n = {key.removeprefix(f"{joint}."): value for key, value in numbers.items() if key.startswith(f"{joint}.")}
    x, v, a = (savgol_filter(log[f"{joint}.position"], 41, 3, deriv=k, delta=PERIOD_S) for k in (0, 1, 2))
    length = log["prismatic.position"]
    mass = numbers["hub_inertia"] + numbers["payload"] * length**2 if joint == "rotary" else numbers["carriage"] + numbers["payload"] + 4.6
    opening = log[f"{joint}.command_V"] / n["full_scale"] + n["null"]
    side = np.tanh(v / n["fade"])
    friction = (n["coulomb"] + n["stiction"] * np.exp(-((v / n["stribeck"]) ** 2))) * side + n["viscous"] * v
    area = 0.5 * (n["area_a"] + n["area_b"])
    load = (mass * a + friction) / area
    if f"{joint}.pressure_a_Pa" in log:
        load = log[f"{joint}.pressure_a_Pa"] - n["area_b"] / n["area_a"] * log[f"{joint}.pressure_b_Pa"]
    supply = log[f"{joint}.supply_pressure_Pa"]
    flow = n["flow"] * opening * np.sqrt(np.maximum(supply - np.sign(opening) * load, 1e5) / 2)
    residual = area * v + n["cross"] * load - flow
    rate = np.gradient(opening, PERIOD_S)
    library = {
        "coulomb_friction": side, "stiction": np.exp(-((v / n["stribeck"]) ** 2)) * side, "viscous_friction": v,
        "asymmetric_friction": np.abs(side), "pressure_friction": np.abs(load) * side, "inertia_error": a, "gravity": np.sin(x),
        "valve_deadband": np.tanh(opening / 0.01), "valve_null_bias": np.ones_like(v), "valve_flow_asymmetry": np.abs(opening),
        "valve_saturation": np.sign(opening) * np.maximum(np.abs(opening) - 0.3, 0), "valve_lag": rate, "transport_delay": rate,
        "cross_leakage": load, "hose_compliance": np.gradient(savgol_filter(load, 41, 3), PERIOD_S),
    }  # fmt: skip
    weak = {(name, joint): _weak(column) for name, column in library.items()}
    weak |= {("payload_error", "link"): _weak(a * length**2)} if joint == "rotary" else {}
    known = [column for name, column in weak.items() if name in present]
    always = np.column_stack([_weak(flow), *known])
    return Balance(_weak(residual), {name: c for name, c in weak.items() if name not in present}, always)


def _supply(numbers: Numbers, log: Mapping[str, Array]) -> Balance:
    """Measured supply pressure against the set one."""
    flows = [numbers[f"{j}.flow"] * np.abs(log[f"{j}.command_V"]) / numbers[f"{j}.full_scale"] * 2600 for j in ("rotary", "prismatic")]
    total = flows[0] + flows[1]
    mean = 0.5 * (log["rotary.supply_pressure_Pa"] + log["prismatic.supply_pressure_Pa"])
    library = {
        ("line_loss", "supply"): _weak(flows[0] ** 2 + flows[1] ** 2),
        ("supply_droop", "supply"): _weak(np.cumsum(total - total.mean())),
    }
    return Balance(_weak(mean - numbers["supply"]), library, np.ones((len(_weak(mean)), 1)))


def _scaled(balance: Balance) -> tuple[Array, Array, list[Name]]:
    """Residual and candidate columns with what always takes part projected out; columns of unit length, residual too."""
    q, _ = np.linalg.qr(balance.always)
    names = list(balance.candidates)
    table = np.column_stack([balance.candidates[name] for name in names])
    table, rest = table - q @ (q.T @ table), balance.residual - q @ (q.T @ balance.residual)
    return table / np.maximum(np.linalg.norm(table, axis=0), 1e-30), rest / max(float(np.linalg.norm(rest)), 1e-30), names


def stlsq(fit: Balance, holdout: Balance) -> list[tuple[float, Name]]:
    """Sequentially thresholded least squares; the threshold is the one that predicts the other log best."""
    table, rest, names = _scaled(fit)
    other, other_rest, _ = _scaled(holdout)
    best: tuple[float, list[tuple[float, Name]]] = (1.0, [])
    for threshold in THRESHOLDS:
        kept = list(range(len(names)))
        values = np.zeros(len(names))
        for _ in range(10):
            values = np.zeros(len(names))
            values[kept] = np.linalg.lstsq(table[:, kept], rest, rcond=1e-8)[0]
            again = [k for k in kept if abs(values[k]) > threshold]
            if again == kept or not again:
                kept = again
                break
            kept = again
        if not kept:
            continue
        refit = np.linalg.lstsq(other[:, kept], other_rest, rcond=1e-8)[0]
        left = float(np.sum((other_rest - other[:, kept] @ (0.5 * (refit + values[kept]))) ** 2))
        if left < best[0] - 0.02:
            best = (left, [(abs(float(values[k])), names[k]) for k in kept])
    return best[1]


def forward_bic(fit: Balance) -> list[tuple[float, Name]]:
    """Greedy forward selection while n ln(RSS/n) + k ln n falls, every bump counted as independent."""
    table, rest, names = _scaled(fit)
    n, chosen, left = len(rest), list[int](), 1.0
    found: list[tuple[float, Name]] = []
    while len(chosen) < MOST:
        trials = []
        for k in set(range(len(names))) - set(chosen):
            columns = table[:, [*chosen, k]]
            values = np.linalg.lstsq(columns, rest, rcond=1e-8)[0]
            trials.append((float(np.sum((rest - columns @ values) ** 2)), k))
        if not trials:
            break
        reached, k = min(trials)
        if n * np.log(max(reached, 1e-30) / left) + np.log(n) >= 0:
            break
        found.append((left - reached, names[k]))
        chosen.append(k)
        left = reached
    return found
