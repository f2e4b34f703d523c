"""`identify`: sweeps, multisines and small moves on the rig or its simulation; or what existing logs say."""

from __future__ import annotations

import argparse
import datetime
import json
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import ConfigError, Mend, UsageError
from daemon.cli.connection import add_json_option, connect
from daemon.cli.options.numbers import COUNT, SEED
from daemon.cli.shown.progress import progress_lines
from daemon.cli.shown.shown_units import add_si_option, sentences_for

if TYPE_CHECKING:
    from collections.abc import Sequence

    from config.loading.load import LoadedRig
    from tuning.experiments.experiments import CampaignRun

WHAT = ("sweep", "multisine", "map", "payload", "all")


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("rig", nargs="?", default="ornl_testbed", metavar="RIG", help="a rig file or the name of a shipped one")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--simulated", action="store_true", help="in lockstep on the rig file's plant (default)")
    where.add_argument("--on-rig", action="store_true", help="on the armed rig, through the daemon")
    where.add_argument("--log", type=Path, action="append", default=[], metavar="LOG", help="no runs: use this log; may be repeated")
    parser.add_argument("--what", choices=WHAT, default="all", help="what to identify (default all)")
    parser.add_argument("--joint", help="the joint that sweeps and multisines excite (default rotary, or the axis)")
    parser.add_argument("--amplitudes", help="on the command (default 0.1 V, 0.3 V, 1 V; of an axis from its limits)")
    parser.add_argument("--extensions", metavar="LIST", help="of an arm, e.g. '24 in, 36 in' (default: over the travel)")
    parser.add_argument("--temperatures", metavar="LIST", help="of the oil, simulated rig only, e.g. '20 degC, 40 degC, 60 degC'")
    parser.add_argument(
        "--payloads", metavar="LIST", help="known payloads, simulated rig only, e.g. '0 lb, 45 lb'; the map is made with each"
    )
    parser.add_argument("--band", help="of sweeps and multisines (default 0.2 Hz, 8 Hz; of an axis beyond its resonance)")
    parser.add_argument("--realisations", type=COUNT, default=3, help="multisines with other phases at every condition (default 3)")
    parser.add_argument("--seed", type=SEED, default=0, help="of the simulated sensors' noise")
    parser.add_argument("--by", default="", help="who identifies (default: this user and computer)")
    parser.add_argument("--valid-days", type=COUNT, default=180, help="how long the record may be used (default 180)")
    parser.add_argument("--out", type=Path, default=Path("identified"), metavar="DIR", help="where the results go (default ./identified)")
    add_si_option(parser)
    add_json_option(parser)
    parser.set_defaults(run_command=_identify)


def _identify(arguments: argparse.Namespace) -> int:
    from config.loading.calibration_record import load_record
    from daemon.host.host_facts import user_and_host
    from tuning.identification.identification import identify
    from tuning.identification.identify_plots import summary, write_pictures
    from tuning.identification.record_file import as_dict, write_record, write_results

    progress = progress_lines(arguments.json)
    source = "logs" if arguments.log else "rig" if arguments.on_rig else "simulated"
    found = identify(_logs(arguments, progress), progress)
    by = arguments.by or user_and_host()
    record, today = _record(arguments, found.rig.name), datetime.date.today()
    write_record(found, record, by, source, today, arguments.valid_days)
    written = [record, write_results(found, arguments.out / "results.json"), *write_pictures(found, arguments.out)]
    if arguments.json:
        print(json.dumps({**as_dict(found), "record": str(record), "written": [str(path) for path in written]}))
        return 0
    print("\n".join([*summary(found, arguments.si), f"written: {', '.join(map(str, written))}"]))
    if load_record(record).link is not None:
        print(f"next: write this line into the rig file, then `longreach check` it:\n  identified: {{record: {record}}}")
    return 0


def _record(arguments: argparse.Namespace, rig_name: str) -> Path:
    """Where the calibration record goes; a rig file may refer to the one of this morning. UsageError where it is there."""
    from config.whole_file import refuse_existing

    record = arguments.out / f"{rig_name}-{datetime.date.today()}.yaml"
    refuse_existing(record, "calibration record", "Give this one a folder of its own with --out.", arguments.out, "--out")
    return Path(record)


def _logs(arguments: argparse.Namespace, progress: Any) -> list[Path]:
    from config.loading.load import load_rig
    from config.loading.stand_in import with_simulated_devices
    from daemon.cli.tune.identify_runs import in_lockstep, on_daemon
    from tuning.experiments.experiments import experiments, must_ring

    if arguments.log:
        return list(arguments.log)
    loaded = load_rig(arguments.rig)
    wanted = experiments(loaded.rig, _campaign(arguments, loaded))
    _record(arguments, loaded.rig.name)  # now, not after an hour of runs
    sentences = sentences_for(loaded.text, arguments.si)
    if arguments.on_rig:
        needed = must_ring(loaded.rig, arguments.what)
        if needed:
            advice = f"Stop longreachd, set {' and '.join(needed)} in the rig file, start it again, identify, and set them back."
            advice += f" `longreachd {shlex.quote(loaded.path)}`"
            raise ConfigError("end-point feedback damps what is to be measured, and no deflection is", where=loaded.path, next_step=advice)
        with connect(arguments) as client:
            return on_daemon(client, wanted, lambda line: progress(sentences.text(line)))
    _refuse_impossible(loaded, wanted)
    logs, seed = arguments.out / "logs", arguments.seed
    return in_lockstep(with_simulated_devices(loaded), wanted, logs, seed, lambda line: progress(sentences.text(line)))


def _refuse_impossible(loaded: LoadedRig, wanted: Sequence[CampaignRun]) -> None:
    """Before any run, where the simulated rig cannot be what a run wants it to be."""
    from config.loading.load import changed_rig

    options = {"temperature": "--temperatures", "payload": "--payloads", "initial": "--extensions"}
    for run in wanted:
        try:
            changed_rig(loaded.text, loaded.path, run.overrides)
        except ConfigError as error:
            what, parts = f"no such run can be made: {run.name}", error.refusal
            mend = dict.fromkeys([option for word, option in options.items() if word in parts.what][:1])
            raise UsageError(what, value=f"{parts.what}: {parts.value}", limit=parts.limit, where=loaded.path, mend=mend) from error


def _campaign(arguments: argparse.Namespace, loaded: LoadedRig) -> Any:
    from dataclasses import replace

    from config.parsing.nearest import nearest, nearest_text
    from tuning.experiments.usual_campaign import usual_campaign

    if arguments.on_rig and (arguments.temperatures or arguments.payloads):
        advice = "Leave --temperatures and --payloads out: both are measured, and the payload mounted is that of link_mode."
        mend = dict.fromkeys(("--temperatures", "--payloads"))
        raise UsageError("oil temperature and payload of a rig cannot be set by command", next_step=advice, mend=mend)
    usual = usual_campaign(loaded.rig, arguments.what)
    joint = arguments.joint or usual.joint
    if joint not in loaded.rig.joints:
        what = f"unknown joint {joint!r}{nearest_text(joint, loaded.rig.joints)}"
        mend = {"--joint": nearest(joint, loaded.rig.joints) or usual.joint}
        raise UsageError(what, limit=", ".join(loaded.rig.joints), where="--joint", mend=mend)
    if loaded.rig.arm.kind == "single_axis" and (arguments.extensions or arguments.payloads):
        advice, mend = "Leave --extensions and --payloads out.", dict.fromkeys(("--extensions", "--payloads"))
        raise UsageError("a single axis has no link", where=loaded.path, next_step=advice, mend=mend)
    band = _band(arguments.band) if arguments.band else usual.band_Hz
    return replace(
        usual,
        joint=joint,
        amplitudes_V=_list(arguments.amplitudes, "V", "--amplitudes") or usual.amplitudes_V,
        places=_list(arguments.extensions, "m", "--extensions") or usual.places,
        temperatures_C=_list(arguments.temperatures, "degC", "--temperatures"),
        payloads_kg=_list(arguments.payloads, "kg", "--payloads"),
        band_Hz=band,
        realisations=arguments.realisations,
    )


def _band(text: str) -> tuple[float, float]:
    low, high = _list(text, "Hz", "--band", 2)
    if not 0.0 < low < high:
        advice, mend = "Write the lower frequency first, above 0.", {"--band": f"{high:g} Hz, {low:g} Hz" if 0.0 < high < low else None}
        raise UsageError("no band", value=text, where="--band", next_step=advice, mend=mend)
    return low, high


def _list(text: str | None, unit: str, option: str, count: int | None = None) -> tuple[float, ...]:
    """Quantities separated by commas, in SI."""
    from config.units import to_si

    try:
        values = tuple(to_si(part.strip(), unit) for part in text.split(",")) if text else ()
    except ConfigError as error:
        what, parts = f"{option} is a list of quantities in {unit}", error.refusal.mend
        mend = {option: _with_parts(str(text), parts) if parts else None}
        raise UsageError(what, value=text, where=option, next_step=str(error), mend=mend) from error
    if count is not None and len(values) != count:
        advice = f"Give {count}, or leave {option} out."
        raise UsageError("wrong number of values", value=len(values), limit=count, where=option, next_step=advice, mend={option: None})
    return values


def _with_parts(text: str, better: Mend) -> str:
    """The list with those of its parts put right that `better` names."""
    return ", ".join(better.get(part.strip()) or part.strip() for part in text.split(","))
