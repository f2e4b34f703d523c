"""The cases of a study, all drawn from one seed: what is hidden, how large, on which logs. See docs/results/blind.md for the protocol."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from config.loading.load import load_rig
from tests.blind.changed_numbers import CHANGEABLE, draw_times, stated
from tests.blind.truth.effects import STRANGE
from tests.blind.truth.friction import BRISTLE, RIGID, SLIP
from tests.blind.truth.session import Hidden, Setting

RIG = "ornl_testbed"
FIT, HOLDOUT = ("strokes+multisine", 16.0), ("reversals+stairs", 14.0)
SECOND_FIT = ("stairs+multisine", 14.0)  # of cases with two logs to fit
# Sizes and sensors of the single effects: every effect is in turn in each of a round. 3 and 10 times come first: they are asked for.
ROUNDS = (((3.0, False), (10.0, True), (3.0, True), (10.0, False)), ((1.0, True),))
NULLS, PAIRS, STRANGE_SEEDS, POOR_SEEDS, CHANGED, TWO_LOGS = 60, 40, 6, 5, 40, 20
FORMS = (SLIP, BRISTLE, SLIP, RIGID)  # of friction, in every four cases of a group; see docs/results/blind.md
SIZES = Path(__file__).with_name("smallest_visible.json")

# One place of each effect. bulk_modulus_temperature needs hours of warming up, no log of half a minute shows it; to be named on such logs,
# says the search, entrained_air would have to be 0.09 to 0.28 of the oil at atmospheric pressure.
PLACES: Sequence[tuple[str, str]] = (
    ("coulomb_friction", "rotary"), ("stiction", "prismatic"), ("viscous_friction", "rotary"), ("asymmetric_friction", "prismatic"),
    ("pressure_friction", "rotary"), ("backlash", "rotary"), ("inertia_error", "rotary"), ("gravity", "rotary"),
    ("valve_deadband", "rotary"), ("valve_hysteresis", "prismatic"), ("valve_null_bias", "rotary"), ("valve_saturation", "prismatic"),
    ("valve_lag", "rotary"), ("valve_flow_asymmetry", "rotary"), ("transport_delay", "prismatic"), ("cross_leakage", "rotary"),
    ("external_leakage", "prismatic"), ("hose_compliance", "prismatic"), ("supply_droop", "supply"),
    ("return_back_pressure", "supply"), ("line_loss", "supply"), ("payload_error", "link"), ("link_flexibility", "link"),
    ("link_damping_error", "link"), ("sensor_delay", "sensor:tip.deflection"), ("sensor_scale", "sensor:prismatic.position"),
    ("sensor_offset", "sensor:tip.deflection"), ("sensor_quantization", "sensor:prismatic.position"),
    ("sensor_polarity", "sensor:tip.deflection"),
)  # fmt: skip
# Sizes that no single number scales: values at 1, 3 and 10 times.
BY_HAND: Mapping[str, Mapping[float, float]] = {
    "sensor_polarity": {1.0: -1.0, 3.0: -1.0, 10.0: -1.0},
    "valve_saturation": {1.0: 0.42, 3.0: 0.35, 10.0: 0.2},  # of the full opening; the logs ask for 0.6
    "sensor_quantization": {1.0: 25e-6, 3.0: 75e-6, 10.0: 250e-6},  # m; the sensor's own step is 25 µm
    "link_flexibility": {1.0: 35567.5, 3.0: 11856.0, 10.0: 3556.75},  # N m²; ten times is the rig's own link
}
# Effects that the poor maneuver (one joint, one kind of motion) can hardly tell from their look-alikes.
POOR = (
    (("coulomb_friction", "rotary"), "strokes"), (("valve_deadband", "rotary"), "strokes"), (("valve_lag", "rotary"), "stairs"),
    (("transport_delay", "prismatic"), "stairs"), (("hose_compliance", "prismatic"), "strokes"),
    (("valve_null_bias", "rotary"), "stairs"), (("viscous_friction", "rotary"), "stairs"),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Case:
    """One case with its answer. `removed`: effects taken out of the rig file that the finder gets."""

    name: str  # tells nothing
    group: str
    setting: Setting
    removed: tuple[tuple[str, str], ...]
    multiple: float  # of the smallest visible size; 0 where there is none
    fit: tuple[str, float]
    holdout: tuple[str, float]
    second_fit: tuple[str, float] | None = None

    def as_json(self) -> str:
        return json.dumps(asdict(self))

    @staticmethod
    def from_json(text: str) -> Case:
        raw = json.loads(text)
        hidden = tuple(Hidden(**item) for item in raw["setting"].pop("hidden"))
        raw["setting"] = Setting(hidden=hidden, **raw["setting"])
        raw["removed"] = tuple(tuple(pair) for pair in raw["removed"])
        logs = {key: tuple(raw[key]) for key in ("fit", "holdout", "second_fit") if raw.get(key)}
        return Case(**raw | logs)

    @property
    def truth(self) -> tuple[tuple[str, str], ...]:
        """Names that are right; none for an effect outside the library."""
        return tuple((h.effect, h.where) for h in self.setting.hidden if h.effect not in STRANGE)


@dataclass(frozen=True, slots=True)
class Size:
    """The smallest size of one effect that the finder says it would see (negative: it lowers its number), and its value when absent."""

    visible: float
    neutral: float
    limit: float  # of |value − neutral|, the largest plausible

    def value(self, multiple: float, side: float) -> float:
        return self.neutral + side * min(max(multiple * self.visible, -self.limit), self.limit)


Key = tuple[str, str, float, bool]  # effect, place, form of friction, chamber pressures logged


def sizes(path: Path = SIZES) -> dict[Key, Size]:
    rows = json.loads(path.read_text())["sizes"]
    return {(r["effect"], r["where"], r["form"], r["chambers"]): Size(r["visible"], r["neutral"], r["limit"]) for r in rows}


def cases(master_seed: int, known: Mapping[Key, Size]) -> list[Case]:
    """All cases in the order in which they are run: every stretch of them has a fair share of every group."""
    draw = np.random.default_rng(master_seed)
    groups = [_single(draw), _null(draw), _pairs(draw), _strange(draw), _poor(draw), _changed(draw), _two_logs(draw)]
    shares = (29, 12, 8, 6, 6, 8, 4)  # of 73 cases at the start of a study
    forms = [[form for _ in range(0, len(rows), len(FORMS)) for form in draw.permutation(FORMS)] for rows in groups]
    ranked = sorted(((k + 0.5) / share, g, k) for g, (rows, share) in enumerate(zip(groups, shares, strict=True)) for k in range(len(rows)))
    return [_named(number, groups[g][k], float(forms[g][k]), known) for number, (_, g, k) in enumerate(ranked)]


def _named(number: int, case: Case, form: float, known: Mapping[Key, Size]) -> Case:
    """With its number and form of friction, and what is hidden in the size that this form and the sensors call for."""
    setting = replace(case.setting, friction_form=form)
    hidden = setting.hidden if case.group == "changed" else tuple(_sized(h, setting, known) for h in setting.hidden)
    return replace(case, name=f"case-{number:04d}", setting=replace(setting, hidden=hidden))


def _sized(item: Hidden, setting: Setting, known: Mapping[Key, Size]) -> Hidden:
    if item.effect in BY_HAND or item.effect in STRANGE:
        return item
    size = known[(item.effect, item.where, setting.friction_form, setting.chambers)]
    return replace(item, value=size.value(abs(item.value), float(np.sign(item.value))))


def _seed(draw: np.random.Generator) -> int:
    return int(draw.integers(1, 2**31))


def _hidden(place: tuple[str, str], multiple: float, draw: np.random.Generator) -> Hidden:
    """Its value in multiples of the smallest visible size, negative for the other direction, until `_named` knows the rest."""
    effect, where = place
    if effect in BY_HAND:
        return Hidden(effect, where, BY_HAND[effect][multiple])
    side = float(draw.choice([-1, 1])) if effect in TWO_SIDED else 1.0
    return Hidden(effect, where, side * multiple)


CONSTANTS = ("soft_presliding",)  # the search has the seal's stiffness among its constants
TWO_SIDED = ("asymmetric_friction", "gravity", "valve_null_bias", "valve_flow_asymmetry", "sensor_offset")


def _case(group: str, draw: np.random.Generator, hidden: Sequence[Hidden], multiple: float, chambers: bool, **changes: object) -> Case:
    setting = Setting(_seed(draw), tuple(hidden), bool(changes.get("jitter", True)), SLIP, chambers)
    removed = tuple((h.effect, h.where) for h in hidden if h.effect not in STRANGE and group != "changed")
    fit, holdout, second = changes.get("fit", FIT), changes.get("holdout", HOLDOUT), changes.get("second_fit")
    return Case("", group, setting, removed, multiple, fit, holdout, second)  # type: ignore[arg-type]


def _single(draw: np.random.Generator) -> list[Case]:
    found = []
    for kinds in ROUNDS:
        order = draw.permutation(len(PLACES))
        for turn in range(len(kinds)):
            for position, k in enumerate(order):
                multiple, chambers = kinds[(position + turn) % len(kinds)]
                found.append(_case("single", draw, [_hidden(PLACES[k], multiple, draw)], multiple, chambers))
    return found


def _null(draw: np.random.Generator) -> list[Case]:
    return [_case("null", draw, [], 0.0, k % 4 >= 2, jitter=k % 2 == 0) for k in range(NULLS)]


def _pairs(draw: np.random.Generator) -> list[Case]:
    """Two effects of different places in the table, both at ten times the smallest visible size."""
    found = []
    while len(found) < PAIRS:
        a, b = (PLACES[k] for k in draw.choice(len(PLACES), 2, replace=False))
        if not {a[0], b[0]} & {"sensor_polarity", "link_flexibility"}:
            hidden = [_hidden(place, 10.0, draw) for place in (a, b)]
            found.append(_case("pair", draw, hidden, 10.0, len(found) % 2 == 1))
    return found


def _strange(draw: np.random.Generator) -> list[Case]:
    found = []
    for repeat in range(STRANGE_SEEDS):
        for effect in (name for name in STRANGE if name not in CONSTANTS):
            where = ("rotary", "prismatic")[repeat % 2]
            found.append(_case("out_of_library", draw, [Hidden(effect, where, 1.0)], 0.0, repeat >= 2))
    return found


def _poor(draw: np.random.Generator) -> list[Case]:
    found = []
    for _ in range(POOR_SEEDS):
        for place, kind in POOR:
            hidden = [_hidden(place, 10.0, draw)]
            found.append(_case("look_alike", draw, hidden, 10.0, False, fit=(kind, 9.0), holdout=("multisine", 6.0)))
    return found


def _changed(draw: np.random.Generator) -> list[Case]:
    """Numbers that the rig file has, worn or dirty: `multiple` times what is stated."""
    rig, found = load_rig(RIG).rig, []
    while len(found) < CHANGED:
        for k in draw.permutation(len(CHANGEABLE)):
            times = draw_times(CHANGEABLE[k], draw)
            hidden = [Hidden(*CHANGEABLE[k], times * stated(rig, CHANGEABLE[k]))]
            found.append(_case("changed", draw, hidden, times, len(found) % 2 == 1))
    return found[:CHANGED]


def _two_logs(draw: np.random.Generator) -> list[Case]:
    """Single effects at 3 and 10 times, with two logs to fit."""
    found = []
    for n, k in enumerate(draw.permutation(len(PLACES))[:TWO_LOGS]):
        multiple, chambers = ROUNDS[0][n % len(ROUNDS[0])]
        found.append(_case("two_logs", draw, [_hidden(PLACES[k], multiple, draw)], multiple, chambers, second_fit=SECOND_FIT))
    return found
