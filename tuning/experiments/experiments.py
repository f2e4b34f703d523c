"""Which runs an identification needs: sweeps and multisines at several amplitudes, places and temperatures, small moves for the link.

One condition is varied at a time about the middle of each list: a full grid would take hours and add little.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from config.schema.rig import Rig

What = Literal["sweep", "multisine", "map", "payload", "all"]
SWEEP_S, FADE_S = 40.0, 1.0
PERIOD_S, PERIODS = 10.0, 3
TIP_STEP_M, STEP_HOLD_S = 0.015, 3.0  # of the tip: it rings by no more than twice as much, within the deflection sensor's range


SAFE_GAIN = 20.05  # V/rad (0.35 V/deg): without end-point feedback the joint damps the link below about 0.40 V/deg


@dataclass(frozen=True, slots=True)
class Campaign:
    """What is varied. `places`: extensions of an arm (m), positions of a single axis (m or rad). Temperatures and payloads can only be set
    on the simulated rig; empty: as it is. `pace`: how many times as fast as the paper's joint, which makes the waves shorter."""

    what: What
    joint: str
    amplitudes_V: tuple[float, ...]
    places: tuple[float, ...]
    temperatures_C: tuple[float, ...] = ()
    payloads_kg: tuple[float, ...] = ()
    band_Hz: tuple[float, float] = (0.2, 8.0)
    realisations: int = 3
    lines: int = 24
    pace: float = 1.0


@dataclass(frozen=True, slots=True)
class CampaignRun:
    """One run: text of its maneuver, and what to change in the rig file of a simulated rig."""

    name: str
    maneuver: str
    overrides: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class _Point:
    amplitude_V: float
    place: float
    temperature_C: float | None
    payload_kg: float | None


def experiments(rig: Rig, campaign: Campaign) -> list[CampaignRun]:
    """Every run, in the order in which to make them."""
    every = ("sweep", "multisine", "map", "payload") if rig.link_mode is not None else ("sweep", "multisine")
    kinds = every if campaign.what == "all" else (campaign.what,)
    makers = {"sweep": _sweeps, "multisine": _multisines, "map": _map, "payload": _payload}
    return [experiment for kind in kinds for experiment in makers[kind](rig, campaign)]


def default_places(rig: Rig, what: What) -> tuple[float, ...]:
    """Over the travel of the extension, or of the axis: three for responses, seven for the link's map, which wants both ends."""
    low, high = rig.joints[_placed(rig)].travel
    shares = (0.0, 0.15, 0.3, 0.5, 0.7, 0.85, 1.0) if what in ("map", "all") else (0.5,) if what == "payload" else (0.25, 0.5, 0.75)
    return tuple(low + share * (high - low) for share in shares)


def _sweeps(rig: Rig, campaign: Campaign) -> list[CampaignRun]:
    return [_sweep(rig, campaign, point) for point in _points(campaign)]


def _multisines(rig: Rig, campaign: Campaign) -> list[CampaignRun]:
    return [_multisine(rig, campaign, point, seed) for point in _points(campaign) for seed in range(1, campaign.realisations + 1)]


def _map(rig: Rig, campaign: Campaign) -> list[CampaignRun]:
    middle = _nominal(campaign)
    payloads: tuple[float | None, ...] = campaign.payloads_kg or (None,)
    points = [replace(middle, place=x, payload_kg=m) for m in payloads for x in campaign.places]
    return [CampaignRun(f"map, {_told(rig, point)}", _steps(rig, point), _ringing(rig, point)) for point in points]


def _payload(rig: Rig, campaign: Campaign) -> list[CampaignRun]:
    point = _nominal(campaign)
    return [CampaignRun(f"payload, {_told(rig, point)}", _steps(rig, point), _ringing(rig, point))]


def _nominal(campaign: Campaign) -> _Point:
    return _Point(
        _middle(campaign.amplitudes_V), _middle(campaign.places),
        _middle(campaign.temperatures_C) if campaign.temperatures_C else None,
        campaign.payloads_kg[0] if campaign.payloads_kg else None,
    )  # fmt: skip


def _points(campaign: Campaign) -> list[_Point]:
    middle = _nominal(campaign)
    points = [replace(middle, amplitude_V=volts) for volts in campaign.amplitudes_V]
    points += [replace(middle, place=x) for x in _few(campaign.places)]
    points += [replace(middle, temperature_C=t) for t in campaign.temperatures_C]
    return list(dict.fromkeys(points))


def _few(values: tuple[float, ...]) -> tuple[float, ...]:
    """Three of many: responses take minutes, and the ends of the travel leave the joint no room."""
    return values if len(values) <= 3 else (values[1], _middle(values), values[-2])


def _middle(values: tuple[float, ...]) -> float:
    return values[len(values) // 2]


def _placed(rig: Rig) -> str:
    """The joint whose position is the place of a run."""
    return next(iter(rig.joints)) if rig.arm.kind == "single_axis" else "prismatic"


def _stands(rig: Rig, point: _Point) -> dict[str, str]:
    """Where every joint stands at the start."""
    name = _placed(rig)
    place = f"{point.place!r} {rig.joints[name].position_unit}"
    return {name: place} if rig.arm.kind == "single_axis" else {"rotary": "0 rad", name: place}


def _head(rig: Rig, point: _Point, kind: str) -> str:
    start = ", ".join(f"{name}: {place}" for name, place in _stands(rig, point).items())
    return f"longreach: maneuver/1\nname: identify_{kind}\nkind: {kind}\nstart: {{{start}}}\n"


def _excite(rig: Rig, campaign: Campaign, point: _Point, kind: str) -> str:
    low, high = campaign.band_Hz
    volts = f'joint: {campaign.joint}\n"on": command\namplitude: {point.amplitude_V!r} V\n'
    return f"{_head(rig, point, kind)}{volts}from: {low!r} Hz\nto: {high!r} Hz\nfade: {_quicker(rig, campaign, FADE_S)!r} s\n"


def _sweep(rig: Rig, campaign: Campaign, point: _Point) -> CampaignRun:
    text = f"{_excite(rig, campaign, point, 'sine_sweep')}duration: {_quicker(rig, campaign, SWEEP_S)!r} s\n"
    return CampaignRun(f"sweep, {_told(rig, point)}", text, _overrides(rig, point))


def _multisine(rig: Rig, campaign: Campaign, point: _Point, seed: int) -> CampaignRun:
    period_s = _quicker(rig, campaign, PERIOD_S)
    wave = f"period: {period_s!r} s\nperiods: {PERIODS}\nlines: {campaign.lines}\nseed: {seed}\ncrest_limit: 3\n"
    return CampaignRun(f"multisine {seed}, {_told(rig, point)}", _excite(rig, campaign, point, "multisine") + wave, _overrides(rig, point))


def _quicker(rig: Rig, campaign: Campaign, seconds: float) -> float:
    """As many whole cycles as a joint of that pace needs."""
    return round(seconds / campaign.pace * rig.loop.rate_Hz) / rig.loop.rate_Hz


def _steps(rig: Rig, point: _Point) -> str:
    """Out and back, so that the arm ends where it began."""
    step = TIP_STEP_M / point.place
    steps = "".join(f"  - {{joint: rotary, by: {by!r} rad, hold: {STEP_HOLD_S} s}}\n" for by in (step, -step))
    return f"{_head(rig, point, 'joint_steps')}steps:\n{steps}"


def _overrides(rig: Rig, point: _Point) -> tuple[str, ...]:
    changes = [f"plant.joints.{name}.initial={place}" for name, place in _stands(rig, point).items()]
    if point.temperature_C is not None:
        changes.append(f"plant.oil.initial_temperature={point.temperature_C!r} degC")
    if point.payload_kg is not None:
        changes += [f"{place}.payload={point.payload_kg!r} kg" for place in ("plant.link", "link_mode")]
    return tuple(changes)


def must_ring(rig: Rig, what: What) -> tuple[str, ...]:
    """What to change in the rig file, so that the link is not damped while it is measured; nothing where the deflection is measured."""
    if rig.end_point is None or rig.end_point.gain == 0.0 or "tip.deflection" in rig.signals or what in ("sweep", "multisine"):
        return ()
    return "end_point.gain=0", f"servo.rotary.gain={min(rig.servo['rotary'].gain, SAFE_GAIN)!r} V/rad"


def _ringing(rig: Rig, point: _Point) -> tuple[str, ...]:
    return (*_overrides(rig, point), *must_ring(rig, "map"))


def _told(rig: Rig, point: _Point) -> str:
    parts = [f"{point.amplitude_V:g} V", f"{point.place:.4f} {rig.joints[_placed(rig)].position_unit}"]
    parts += [] if point.temperature_C is None else [f"{point.temperature_C:g} degC"]
    parts += [] if point.payload_kg is None else [f"{point.payload_kg:.2f} kg"]
    return ", ".join(parts)
