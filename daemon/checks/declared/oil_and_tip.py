"""Limits of the section `interlocks:` on pressures, oil temperature and tip acceleration, for the signals that the rig has."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

from config.schema.rig import Rig
from daemon.checks.checks import Reaction
from daemon.checks.declaration import Declaration, Family, Limits, Stage, Subject, measured, open_limits, source_of

SUPPLY_LOST = 0.5  # of the least supply pressure: less is not low pressure but none


def _joints(rig: Rig) -> Iterator[Subject]:
    """`supply` and `return`: where the pressures of the joint's valve come from; no such key where nothing measures one."""
    for joint in rig.joints:
        ports = {port: f"{joint}.{port}_pressure" for port in ("supply", "return")}
        yield {"joint": joint, **{port: source_of(rig, signal) for port, signal in ports.items() if signal in rig.signals}}


def _supply_lost(rig: Rig, subject: Subject) -> Limits | None:
    least = rig.interlocks.supply_pressure_min_Pa
    return (SUPPLY_LOST * least, inf) if least is not None and "supply" in subject else None


def _supply(rig: Rig, subject: Subject) -> Limits | None:
    limits = rig.interlocks
    return open_limits(limits.supply_pressure_min_Pa, limits.supply_pressure_max_Pa) if "supply" in subject else None


def _return(rig: Rig, subject: Subject) -> Limits | None:
    return open_limits(None, rig.interlocks.return_pressure_max_Pa) if "return" in subject else None


def _tip(rig: Rig, subject: Subject) -> Limits | None:
    most = rig.interlocks.tip_acceleration_max_m_per_s2
    return None if most is None else (-most, most)


LOST = Declaration(
    name="{joint}.supply_pressure lost",
    fact="{joint}.supply_pressure_Pa",
    meaning="gauge pressure at the valve; without it the servo cannot stop the arm, and the arm would jump when it returned",
    unit="Pa",
    limits=_supply_lost,
    limit_from=f"at least {SUPPLY_LOST:.0%} of `interlocks.supply_pressure_min`",
    source="{supply}",
    reaction=Reaction.FAULT,
    advice="Check pump and shut-off valve, then `longreach reset`.",
    age="{joint}.supply_pressure_age_s",
)
SUPPLY = Declaration(
    name="{joint}.supply_pressure limit",
    fact="{joint}.supply_pressure_Pa",
    meaning="gauge pressure at the valve",
    unit="Pa",
    limits=_supply,
    limit_from="`interlocks.supply_pressure_min` to `interlocks.supply_pressure_max`",
    source="{supply}",
    reaction=Reaction.STOP,
    advice="Check pump, accumulator and shut-off valve, then `longreach why`.",
    age="{joint}.supply_pressure_age_s",
)
RETURN = Declaration(
    name="{joint}.return_pressure limit",
    fact="{joint}.return_pressure_Pa",
    meaning="gauge pressure at the valve's return port",
    unit="Pa",
    limits=_return,
    limit_from="at most `interlocks.return_pressure_max`",
    source="{return}",
    reaction=Reaction.STOP,
    advice="Check the return filter, then `longreach why`.",
    age="{joint}.return_pressure_age_s",
)
OIL = Declaration(
    name="reservoir_temperature limit",
    fact="reservoir_temperature_C",
    meaning="oil temperature in the reservoir",
    unit="degC",
    limits=lambda rig, subject: open_limits(rig.interlocks.oil_temperature_min_C, rig.interlocks.oil_temperature_max_C),
    limit_from="`interlocks.oil_temperature_min` to `interlocks.oil_temperature_max`",
    source="{source}",
    reaction=Reaction.STOP,
    advice="Warm the oil up by circulating it, or check the cooler; then `longreach why`.",
    age="reservoir_temperature_age_s",
)
TIP = Declaration(
    name="tip.acceleration limit",
    fact="tip.acceleration_mps2",
    meaning="transverse acceleration of the tip",
    unit="m/s^2",
    limits=_tip,
    limit_from="size at most `interlocks.tip_acceleration_max`",
    source="{source}",
    reaction=Reaction.STOP,
    advice="Use a command filter (`longreach start --shaper adaptive`) or a slower maneuver.",
    age="tip.acceleration_age_s",
)


FAMILIES = (
    Family("Pressures at the valves", Stage.OIL, _joints, (LOST, SUPPLY, RETURN)),
    Family("The reservoir", Stage.OIL, lambda rig: measured(rig, "reservoir_temperature"), (OIL,)),
    Family("The tip", Stage.OIL, lambda rig: measured(rig, "tip.acceleration"), (TIP,)),
)
