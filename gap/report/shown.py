"""What of a search is worth showing: the stages of its cost, the channel that tells most, each effect's fingerprint."""

from __future__ import annotations

from gap.report.fingerprint import Fingerprint, fingerprint_of, seen_in
from gap.report.found import Found
from gap.report.plots import Stage


def stages(found: Found) -> list[Stage]:
    """Hold-out evaluations from the rig file to the file as it was written."""
    steps = [(f"+ {s.trial.candidate.effect}", s.trial.holdout) for s in found.state.steps]
    return [("rig file", found.nominal), ("constants refitted", found.state.constants_only), *steps, ("file as written", found.final)]


def telling_channel(found: Found) -> int:
    """Number of the channel with most of the gap."""
    return found.channels.index(found.places[0].channel) if found.places else 0


def unit_of_channel(found: Found, channel: str) -> str:
    """As the log has it; positions have their joint's."""
    unit = str(found.content["gap"]["channels"][channel]["unit"])
    joint = found.rig.rig.joints.get(channel.split(".")[0])
    return unit or ("" if joint is None else "rad" if joint.motion == "rotary" else "m")


def fingerprints(found: Found) -> list[tuple[str, Fingerprint]]:
    """Every effect against its own variable; without effects, the channel with most of the gap against its region's variable."""
    telling, rig = found.channels[telling_channel(found)], found.rig.rig
    named = [step.trial.candidate for step in found.state.steps]
    own = [(c.label, fingerprint_of(c.effect, c.where, found.channels, telling, rig)) for c in named]
    return own or [(telling, _regional(found, telling))]


def _regional(found: Found, channel: str) -> Fingerprint:
    """The operating variable in which the gap is concentrated, else the velocity."""
    word = found.places[0].region.split(" ")[0] if found.places else ""
    kind = word.rpartition(".")[2]
    return seen_in(channel, kind if kind in ("velocity", "command_V", "position") else "velocity", found.rig.rig)
