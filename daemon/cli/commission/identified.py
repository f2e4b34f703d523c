"""The step that measures what a design needs: payload and link of an arm, or the response of a single axis, beside the rig file's model."""

from __future__ import annotations

import datetime
from dataclasses import replace
from pathlib import Path

from config.errors import ConfigError
from config.loading.stand_in import with_simulated_devices
from daemon.cli.commission.bench import DaemonBench, Ran
from daemon.cli.commission.context import Context
from daemon.cli.commission.record import Outcome, Value
from daemon.cli.tune.identify_runs import in_lockstep
from tuning.experiments.experiments import Campaign, experiments, must_ring
from tuning.experiments.usual_campaign import usual_campaign
from tuning.identification.axis_believed import believed_axis
from tuning.identification.identification import Identification, Response, identify
from tuning.identification.identify_plots import summary
from tuning.identification.record_file import write_record, write_results
from tuning.linear.hydraulic_axis import is_hydraulic_axis
from tuning.loop_design.measured_plant import MeasuredPlant, measured_plants

IDENTIFICATION = "identification"
VALID_DAYS = 180
SIGMAS = 3.0  # a payload further from the believed one than so many uncertainties, and PAYLOAD_SHARE of it, is another payload
PAYLOAD_SHARE = 0.2
ARM_V = 0.3
AXIS_SHARE = 0.2  # of velocity gain and natural frequency: the family that a design must hold for
LEAST_DAMPING_SHARE = 0.5  # of the model without friction, which can only add to it


def identification(context: Context) -> Outcome:
    """Payload and link from small moves, or an axis's response from small waves: a calibration record for the rig file."""
    try:
        campaign = _campaign(context)
    except ConfigError as refusal:  # an electric drive, or no plant
        return Outcome(None, str(refusal))
    needed = must_ring(context.rig, campaign.what) if not context.bench.simulated else ()
    if needed:
        return Outcome(False, f"end-point feedback damps what is to be measured: set {' and '.join(needed)}, then commission again")
    logs = _logs(context, campaign)
    if isinstance(logs, Outcome):
        return logs
    found = identify(logs, context.say)
    record = context.folder / f"{context.rig.name}-{datetime.date.today()}.yaml"
    source = "simulated" if context.bench.simulated else "rig"
    write_record(found, record, context.by, source, datetime.date.today(), VALID_DAYS)
    results = write_results(found, context.folder / "identified.json")
    values = [*_payloads(found), *_axis_values(context, found), *(Value("found", line) for line in summary(found))]
    took_up = f"; the rig file takes them up with identified: {{record: {record}}}" if found.links else ""
    return Outcome(all(value.ok for value in values), f"{len(logs)} runs{took_up}", values, [str(log) for log in logs],
                   [str(record), str(results)])  # fmt: skip


def measured_joint(context: Context) -> list[MeasuredPlant]:
    """What this commissioning has measured of the joint that is designed for; empty where the step did not pass, or needed no waves."""
    made = context.records.get(IDENTIFICATION)
    logs = [Path(log) for log in made.outcome.logs] if made is not None and made.outcome.passed else []
    if context.rig.arm.kind != "single_axis" or not logs or not all(log.exists() for log in logs):
        return []
    return measured_plants(context.rig, [response.measured for response in identify(logs).responses])


def _campaign(context: Context) -> Campaign:
    if context.rig.arm.kind == "single_axis":
        return replace(usual_campaign(context.rig, "multisine"), realisations=1)
    return replace(usual_campaign(context.rig, context.identify), amplitudes_V=(ARM_V,))


def _logs(context: Context, campaign: Campaign) -> list[Path] | Outcome:
    """Logs of the small moves, or the failed step where no run is valid."""
    wanted = experiments(context.rig, campaign)
    waves = f"waves of at most {max(campaign.amplitudes_V):.3g} V" if campaign.what == "multisine" else "small moves"
    context.allow(f"{', '.join(context.rig.joints)}: {len(wanted)} runs of {waves} for the identification")
    if context.bench.simulated:
        return in_lockstep(with_simulated_devices(context.loaded), wanted, context.logs, 0, context.say)
    runs = [_experiment(context, each.name, each.maneuver) for each in wanted]
    valid = [ran.log for ran in runs if ran.valid]
    return valid or Outcome(False, f"no run is valid: {runs[0].reason}", logs=[str(ran.log) for ran in runs])


def _experiment(context: Context, name: str, maneuver: str) -> Ran:
    assert isinstance(context.bench, DaemonBench)
    context.say(name)
    return context.run({"maneuver": {"text": maneuver, "name": name}, "approach": True})


def _payloads(found: Identification) -> list[Value]:
    """Every payload found beside the one that the rig file believes."""
    return [
        Value(f"payload by {each.method}", f"{each.payload_kg:.3f} ± {each.uncertainty_kg:.3f} kg", f"believed {link.believed_kg:.3f} kg",
              abs(each.payload_kg - link.believed_kg) <= max(SIGMAS * each.uncertainty_kg, PAYLOAD_SHARE * link.believed_kg))
        for link in found.links for each in link.payload
    ]  # fmt: skip


def _axis_values(context: Context, found: Identification) -> list[Value]:
    """Every response with the largest waves beside the rig file's plant; what smaller ones give, friction decides, so it is told only."""
    if not is_hydraulic_axis(context.rig):
        return []
    largest = max((response.measured.conditions.amplitude for response in found.responses), default=0.0)
    judged = [each for each in found.responses if each.measured.conditions.amplitude > 0.9 * largest]
    if not judged or any(each.fit is None for each in judged):
        return [Value("response of the axis", "too few lines for a fit", "a fit", False)]
    return [value for response in judged for value in _beside_the_plant(context, response)]


def _beside_the_plant(context: Context, response: Response) -> list[Value]:
    at, fit = response.measured.conditions, response.fit
    assert fit is not None
    unit = context.rig.joints[at.joint].position_unit
    where = f"at {context.shown(at.position, unit, at.joint)}"
    believed = believed_axis(context.rig, at.position, at.oil_C)
    rate = fit.velocity_gain / believed.velocity_gain
    values = [
        Value(f"rate a volt {where}", f"{context.shown_difference(fit.velocity_gain, f'{unit}/s', at.joint)}, {rate:.2f} of the plant's",
              f"{1 - AXIS_SHARE:g} to {1 + AXIS_SHARE:g}", abs(rate - 1.0) <= AXIS_SHARE)
    ]  # fmt: skip
    if believed.natural_Hz is None or believed.damping_ratio is None:
        return values
    frequency, least = fit.natural_Hz / believed.natural_Hz, LEAST_DAMPING_SHARE * believed.damping_ratio
    return [
        *values,
        Value(f"natural frequency {where}", f"{fit.natural_Hz:.2f} Hz, {frequency:.2f} of the plant's {believed.natural_Hz:.2f} Hz",
              f"{1 - AXIS_SHARE:g} to {1 + AXIS_SHARE:g}", abs(frequency - 1.0) <= AXIS_SHARE),
        Value(f"damping {where}", f"{fit.damping_ratio:.3f}, the plant without friction {believed.damping_ratio:.3f}", f">= {least:.3f}",
              fit.damping_ratio >= least),
    ]  # fmt: skip
