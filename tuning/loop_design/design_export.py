"""A design as systems of python-control, written for MATLAB too: plants, measured members of the family, compensator, tip filter.

The file holds everything that the printed margins and damping were computed from:

    u = C(z) · (reference − position + feedback),
    feedback = tip_gain · tip_share · ((kept − lead) · F(z) + lead) · deflection / extension,     (kept, lead) = tip_lead

Margins are those of C(s) with every rigid plant times each of `gain_factors` and with every amplitude; least damping is that of C(z) and
feedback with every flexible plant behind a hold and `delay_periods` whole periods, C times each of `gain_factors`. A single axis has no
link: `rigid` are the places where it slides, `flexible` the same and those where its friction holds it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, nan, pi
from pathlib import Path
from typing import Any

import control
import numpy as np
from scipy.io import loadmat, savemat
from scipy.io.matlab import MatReadError

from config.errors import LogError, UsageError
from config.schema.rig import LinkMode, Rig
from config.whole_file import whole_file
from tuning.linear.family import GAINS, sampled_compensator
from tuning.linear.linear_arm import linear_arm
from tuning.linear.linear_axis import axis_states
from tuning.linear.margins import grid
from tuning.loop_design.arm_design import DELAY_CYCLES, ArmDesign, kept_damping, operating_points
from tuning.loop_design.axis_design import DELAY_PERIODS, axis_places
from tuning.loop_design.measured_plant import MeasuredPlant
from tuning.loop_design.workspace import UNLOADED, places_in
from tuning.transfer import lag_lead
from tuning.variants import plant_of

STATES = (
    "rotary_position_rad", "rotary_velocity_rad_per_s", "spool", "spool_rate_per_s", "pressure_A_Pa", "pressure_B_Pa",
    "tip_deflection_m", "second_shape_m", "tip_deflection_rate_m_per_s", "second_shape_rate_m_per_s",
)  # fmt: skip
INPUT, OUTPUTS = "rotary_command_V", ("rotary_position_rad", "tip_deflection_m")
PLAIN = ("rig", "oil_temperature_C", "sample_time_s", "dead_time_s", "delay_periods", "light_damping", "tip_gain")
WHERE = ("extension_m", "payload_kg", "tip_share", "tip_lead", "light", "position", "opening", "held")
RATIONAL = ("compensator", "sampled_compensator", "tip_filter")


@dataclass(frozen=True, slots=True, eq=False)
class ExportedPlant:
    """The plant linearised at rest somewhere, continuous: V to rad (and m); states, input and outputs carry names with units.

    `tip_share`, `tip_lead`: what the schedules leave of the tip gain there, and its lead. `light`: a stiff or an empty
    link, which only counts for the least damping when less than `light_damping` is left of its own. Of a single axis: its `position`
    (m or rad; NaN of an arm), the share by which its spool is open, and whether friction holds it.
    """

    system: control.StateSpace
    extension_m: float
    payload_kg: float
    tip_share: float = 0.0
    tip_lead: tuple[float, float] = (1.0, 0.0)
    light: bool = False
    position: float = nan
    opening: float = 0.0
    held: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class ExportedDesign:
    """`rigid`: the empty arm with a link that does not bend; `amplitudes`: V and rad (or m) per V as measured, with dead time.

    `compensator` in V per rad (or m), continuous and as difference equations; `tip_filter`: the feedback's low-pass.
    """

    rig: str
    oil_temperature_C: float
    sample_time_s: float
    dead_time_s: float
    delay_periods: int
    gain_factors: tuple[float, ...]
    light_damping: float
    flexible: tuple[ExportedPlant, ...]
    rigid: tuple[ExportedPlant, ...]
    amplitudes: tuple[tuple[float, control.FrequencyResponseData], ...]
    compensator: control.TransferFunction
    sampled_compensator: control.TransferFunction
    tip_gain: float
    tip_filter: control.TransferFunction


def design_systems(rig: Rig, found: ArmDesign) -> ExportedDesign:
    """The chosen compensator with all the plants that it was judged on."""
    servo, period_s, oil = found.chosen.servo, 1.0 / rig.loop.rate_Hz, plant_of(rig).oil
    omega = grid(found.problem.pace)
    measured = [plant for plant in found.problem.plants if isinstance(plant, MeasuredPlant)]
    keep = exp(-2.0 * pi * servo.roll_off_Hz * period_s) if servo.roll_off_Hz > 0.0 else 0.0
    flexible, rigid = _of_arm(rig, rig.link_mode, found.problem.pace) if rig.link_mode is not None else _of_axis(rig)
    return ExportedDesign(
        rig=rig.name,
        oil_temperature_C=oil.initial_temperature_C if oil is not None else nan,
        sample_time_s=period_s,
        dead_time_s=DELAY_CYCLES * period_s,
        delay_periods=0 if rig.link_mode is not None else DELAY_PERIODS,
        gain_factors=GAINS,
        light_damping=kept_damping(rig.link_mode) if rig.link_mode is not None else 0.0,
        flexible=flexible,
        rigid=rigid,
        amplitudes=tuple((plant.amplitude_V, control.frd(plant(omega), omega)) for plant in measured),
        compensator=lag_lead(servo.gain, servo.sections),
        sampled_compensator=sampled_compensator(servo, period_s),
        tip_gain=servo.tip_gain,
        tip_filter=control.tf([1.0 - keep, 0.0], [1.0, -keep], period_s),
    )


def _of_arm(rig: Rig, link: LinkMode, pace: float) -> tuple[tuple[ExportedPlant, ...], tuple[ExportedPlant, ...]]:
    """With its link, and with a link that does not bend."""
    return _flexible(rig, link, pace), tuple(_rigid(rig, extension) for extension, _ in places_in(rig, UNLOADED))


def _of_axis(rig: Rig) -> tuple[tuple[ExportedPlant, ...], tuple[ExportedPlant, ...]]:
    """Everywhere, and where it slides."""
    (joint,) = rig.joints
    unit = rig.joints[joint].position_unit
    found = []
    for place in axis_places(rig):
        names = {"states": axis_states(place.arm, joint, unit), "inputs": [f"{joint}_command_V"], "outputs": [f"{joint}_position_{unit}"]}
        system = control.ss(place.arm.system()[0, 0], **names)
        found.append(ExportedPlant(system, place.arm.extension_m, 0.0, position=place.position, opening=place.opening, held=place.held))
    return tuple(found), tuple(plant for plant in found if not plant.held)


def _flexible(rig: Rig, link: LinkMode, pace: float) -> tuple[ExportedPlant, ...]:
    where = places_in(rig)
    return tuple(
        ExportedPlant(_named(point.arm.system()), extension, payload_kg, point.tip_share, point.tip_lead, point.light)
        for (extension, payload_kg), point in zip(where, operating_points(rig, link, where, pace), strict=True)
    )


def _rigid(rig: Rig, extension_m: float) -> ExportedPlant:
    return ExportedPlant(_named(linear_arm(rig, extension_m, 0.0, rigid=True).system()[0, 0]), extension_m, 0.0)


def _named(system: control.StateSpace) -> control.StateSpace:
    """With the names of states, input and outputs."""
    return control.ss(system, states=list(STATES[: system.nstates]), inputs=[INPUT], outputs=list(OUTPUTS[: system.noutputs]))


def check_export_path(path: Path) -> None:
    """UsageError for a path that cannot be written, before a search of a minute."""
    if not path.parent.is_dir():
        step, mend = f"Make {path.parent}, or give a file in a folder that exists.", {"--export": path.name}
        raise UsageError("there is no folder for the export", value=str(path), where="--export", next_step=step, mend=mend)


def write_design(design: ExportedDesign, path: Path) -> None:
    """The .mat file, under a temporary name first, then renamed. WriteError when it cannot be written."""
    with whole_file(path, "export") as temporary, temporary.open("wb") as file:
        savemat(file, _content(design), long_field_names=True, oned_as="row")


def read_design(path: Path) -> ExportedDesign:
    """The systems of a written file. LogError when it cannot be read or is none of these."""
    try:
        return _design(loadmat(path, simplify_cells=True))
    except (OSError, ValueError, LookupError, TypeError, NotImplementedError, MatReadError) as error:
        raise LogError("the file holds no exported design", value=str(error), where=str(path)) from error


def _content(design: ExportedDesign) -> dict[str, Any]:
    return {
        **{name: getattr(design, name) for name in (*PLAIN, "gain_factors")},
        "flexible": _cells([_plant_fields(plant) for plant in design.flexible]),
        "rigid": _cells([_plant_fields(plant) for plant in design.rigid]),
        "amplitudes": _cells(
            [{"amplitude_V": v, "omega_rad_per_s": frd.omega, "response": frd.frdata[0, 0]} for v, frd in design.amplitudes]
        ),
        **{name: _polynomials(getattr(design, name)) for name in RATIONAL},
    }


def _cells(items: list[dict[str, Any]]) -> Any:
    """A MATLAB cell array."""
    cells = np.empty(len(items), dtype=object)
    cells[:] = items
    return cells


def _plant_fields(plant: ExportedPlant) -> dict[str, Any]:
    system = plant.system
    names = {"states": system.state_labels, "inputs": system.input_labels, "outputs": system.output_labels}
    where = {name: getattr(plant, name) for name in WHERE}
    return {**where, **{name: getattr(system, name) for name in "ABCD"}, **{name: _cells(labels) for name, labels in names.items()}}


def _polynomials(system: control.TransferFunction) -> dict[str, Any]:
    return {"num": system.num[0][0], "den": system.den[0][0], "sample_time_s": system.dt or 0.0}


def _design(content: dict[str, Any]) -> ExportedDesign:
    def rational(item: dict[str, Any]) -> control.TransferFunction:
        return control.tf(np.atleast_1d(item["num"]), np.atleast_1d(item["den"]), item["sample_time_s"])

    return ExportedDesign(
        **{name: content.get(name, 0) if name == "delay_periods" else content[name] for name in PLAIN},
        gain_factors=tuple(content["gain_factors"]),
        flexible=tuple(_plant(item) for item in content["flexible"]),
        rigid=tuple(_plant(item) for item in content["rigid"]),
        amplitudes=tuple((item["amplitude_V"], control.frd(item["response"], item["omega_rad_per_s"])) for item in content["amplitudes"]),
        **{name: rational(content[name]) for name in RATIONAL},
    )


def _plant(item: dict[str, Any]) -> ExportedPlant:
    states, outputs = len(item["A"]), np.size(item["outputs"])
    b, c = np.reshape(item["B"], (states, 1)), np.reshape(item["C"], (outputs, states))
    names = {name: list(np.atleast_1d(item[name])) for name in ("states", "inputs", "outputs")}
    system = control.ss(item["A"], b, c, np.reshape(item["D"], (outputs, 1)), **names)
    where = {name: item[name] for name in WHERE if name in item}
    return ExportedPlant(system, **{**where, "tip_lead": tuple(item["tip_lead"]), **{n: bool(where.get(n)) for n in ("light", "held")}})
