"""What of a search is worth showing: the stages of its cost, the channel that tells most, each effect's fingerprint."""

from __future__ import annotations

from math import isfinite

from config.schema.effect_library import EFFECTS
from config.schema.rig import Rig
from gap.outcome.file_units import FileUnits, Shown
from gap.outcome.found import Found
from gap.outcome.localise import Disagreement
from gap.report.fingerprint import Fingerprint, fingerprint_of, seen_in, unit_of
from gap.report.plots import Stage


def stages(found: Found) -> list[Stage]:
    """Hold-out evaluations from the rig file to the file as it was written."""
    several = found.state.named if len(found.state.named) > 1 else ()
    less = [(f"without {name.suspect.effect}", name.explanation.without) for name in several]
    every = [("rig file", found.nominal), ("constants refitted", found.state.alone_seen), *less, _blind(found)]
    return every if found.with_all_logs is None else [*every, ("with all logs, as written", found.with_all_logs)]


def first_and_blind(found: Found) -> list[Stage]:
    """The rig file, and the last stage that was not fitted to the hold-out."""
    return [("rig file", found.nominal), _blind(found)]


def _blind(found: Found) -> Stage:
    return ("file as written" if found.with_all_logs is None else "predicted blind", found.final)


def measured_in_hold_out(found: Found) -> list[str]:
    """Channels that some hold-out log has: only these can be drawn before and after."""
    return [name for k, name in enumerate(found.channels) if any(isfinite(e.channel_costs[k]) for e in found.nominal)]


def telling_channel(found: Found) -> int:
    """Number of the channel with most of the gap."""
    return found.channels.index(found.places[0].channel if found.places else measured_in_hold_out(found)[0])


def of_channel(found: Found, channel: str, units: FileUnits) -> Shown:
    """How a channel is shown; positions have their joint's unit where the log has none."""
    unit = str(found.content["gap"]["channels"].get(channel, {}).get("unit", ""))
    joint = found.rig.rig.joints.get(channel.split(".")[0])
    return units.channel(channel, unit or ("" if joint is None else joint.position_unit))


def region_text(place: Disagreement, rig: Rig, units: FileUnits) -> str:
    """Where in the range of what a place's disagreement is largest."""
    if place.depends_on:
        found = place.depends_on[0]
        over, size = units.channel(found["variable"], unit_of(found["variable"], rig)), units.other(found["unit"])
        low, high = (pick(range(len(found["imbalance"])), key=found["imbalance"].__getitem__) for pick in (min, max))
        spans = [f"{size.text(found['imbalance'][k])} at {over.span(found['edges'][k : k + 2])}" for k in (low, high)]
        return (
            f"by {found['variable']} ({over.unit}): {spans[0]}, {spans[1]}" if over.unit else f"by {found['variable']}: {'; '.join(spans)}"
        )
    if place.over is None:
        return place.region
    over = units.channel(place.over.variable, unit_of(place.over.variable, rig))
    span = f"{over.span((place.over.low, place.over.high))} {over.unit}".rstrip()
    return f"{place.over.variable.removesuffix('_V').removesuffix('_s')} from {span}: {place.over.times:.1f} times the mean"


def fingerprints(found: Found) -> list[tuple[str, Fingerprint]]:
    """Every effect against its own variable; without effects, the channel with most of the gap against its region's variable."""
    telling, rig = found.channels[telling_channel(found)], found.rig.rig
    named = [name.suspect for name in found.state.named if name.suspect.effect in EFFECTS]
    drawn = measured_in_hold_out(found)
    own = [(c.label, fingerprint_of(c.effect, c.where, drawn, telling, rig)) for c in named]
    return own or [(telling, _regional(found, telling))]


def _regional(found: Found, channel: str) -> Fingerprint:
    """The operating variable in which the gap is concentrated, else the velocity."""
    place = found.places[0] if found.places else None
    named = place.over.variable if place and place.over else str(place.depends_on[0]["variable"]) if place and place.depends_on else ""
    kind = named.rpartition(".")[2]
    return seen_in(channel, kind if kind in ("velocity", "command_V", "position") else "velocity", found.rig.rig)
