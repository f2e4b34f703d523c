"""`device calibrate RIG SENSOR --at VALUE --at VALUE`: readings at known values become the sensor's calibration in the rig file."""

from __future__ import annotations

import argparse
import datetime
import json
import shlex
import statistics
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from daemon.cli.connection import add_json_option
from daemon.cli.devices.words import of_rig
from daemon.cli.options.numbers import COUNT, pause_s, whole
from daemon.cli.options.output_file import RIG_FILE

if TYPE_CHECKING:
    from config.loading.load import LoadedRig
    from config.schema.signals import AnySignal
    from tuning.sensor_calibration.line_fit import Limits, ReferencePoint, SensorCalibration

_DESCRIPTION = """\
Set a sensor's sign, scale and zero. At each --at VALUE you are asked to bring the sensor there; its device is then read (reads only, no
daemon may run). VALUE=COUNTS takes counts that were read before, with no device. Without -o or --write the record is shown, not kept.
"""


def options(parser: argparse.ArgumentParser) -> None:
    parser.description = _DESCRIPTION
    parser.add_argument("rig", metavar="RIG.yaml", help="the rig file")
    parser.add_argument("sensor", metavar="SENSOR", help="name of the signal, for example rotary.position")
    parser.add_argument("--at", action="append", required=True, metavar="VALUE[=COUNTS]", help='a known value: "0 mm", "200 mm=40012"')
    parser.add_argument("--readings", type=COUNT, default=100, help="readings at each value (default 100)")
    parser.add_argument("--every", type=pause_s, default="10 ms", metavar="TIME", help="pause between two readings (default 10 ms)")
    parser.add_argument("--noise-limit", metavar="VALUE", help="largest standard deviation at a point (default 0.1 %% of the span)")
    parser.add_argument("--residual-limit", metavar="VALUE", help="largest distance from the line (default 0.5 %% of the span)")
    parser.add_argument("--reference-uncertainty", metavar="VALUE", help="standard uncertainty of the known values (default 0)")
    parser.add_argument("--valid-days", type=whole(1, 36500), default=365, help="days until it must be repeated (default 365)")
    parser.add_argument("--by", help="who calibrates (default user@host)")
    parser.add_argument("-o", "--output", type=RIG_FILE, metavar="FILE", help="write the rig file with the record here")
    parser.add_argument("--write", action="store_true", help="write the record into RIG.yaml itself")
    add_json_option(parser)
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    from config.loading.load import load_rig, read_text, rig_from_text
    from config.loading.stated_units import stated_units
    from config.whole_file import write_whole
    from daemon.cli.devices.device_numbers import scaling
    from daemon.host.host_facts import user_and_host
    from tuning.sensor_calibration.line_fit import calibrated
    from tuning.sensor_calibration.rig_entry import calibration_entry, with_calibration

    loaded = load_rig(arguments.rig)
    signal = _signal(loaded, arguments.sensor)
    output = _output(arguments, loaded)
    unit, difference = _units(signal)
    limits = _limits(arguments, difference)
    shown = scaling(arguments.sensor, signal, stated_units(loaded.text)).shown
    points = _points(arguments, loaded, unit)
    found = calibrated(points, limits, shown, f"signals.{arguments.sensor}", _watch(arguments, signal))
    by = arguments.by or user_and_host()
    entry = calibration_entry(found, shown, signal.calibration, datetime.date.today(), arguments.valid_days, by)
    text = with_calibration(read_text(Path(loaded.path)), arguments.sensor, entry)
    rig_from_text(text, str(output or loaded.path))
    if output is not None:
        write_whole(output, text, "rig file")
    _report(arguments, found, loaded, entry, difference, output)
    return 0


def _units(signal: AnySignal) -> tuple[str, str]:
    """Of a value and of a difference of values: degC and K."""
    from config.schema.section import unit_of

    fields = type(signal.calibration).model_fields
    return unit_of(fields["offset"]) or "", unit_of(fields["scale"]) or ""


def _limits(arguments: argparse.Namespace, difference: str) -> Limits:
    from tuning.sensor_calibration.line_fit import Limits

    options = ("--noise-limit", "--residual-limit", "--reference-uncertainty")
    given = (arguments.noise_limit, arguments.residual_limit, arguments.reference_uncertainty)
    noise, residual, reference = (_limit(option, text, difference) for option, text in zip(options, given, strict=True))
    return Limits(noise, residual, reference or 0.0)


def _limit(option: str, text: str | None, unit: str) -> float | None:
    from config.errors import UsageError

    if text is None:
        return None
    value = _stated(text, unit, option)
    if value < 0.0:
        raise UsageError("a limit is never negative", value=text, limit="at least 0", where=option, mend={option: text.lstrip("- ")})
    return value


def _signal(loaded: LoadedRig, name: str) -> AnySignal:
    from config.errors import UsageError
    from config.parsing.nearest import nearest_text

    if name not in loaded.rig.signals:
        what = f"the rig has no signal {name!r}{nearest_text(name, loaded.rig.signals)}"
        raise UsageError(what, where="SENSOR", next_step=f"Signals: {', '.join(loaded.rig.signals)}.")
    return loaded.rig.signals[name]


def _output(arguments: argparse.Namespace, loaded: LoadedRig) -> Path | None:
    """Where the rig file with the record goes. A shipped rig is nobody's own."""
    from config.errors import UsageError
    from config.loading.shipped import shipped

    if arguments.write and Path(loaded.path) in shipped("rigs").values():
        advice, mend = "Write a rig file of your own with -o my_rig.yaml.", {"--write": None, "-o": "my_rig.yaml"}
        raise UsageError("a shipped rig file is not changed", value=loaded.path, where="--write", next_step=advice, mend=mend)
    return arguments.output or (Path(loaded.path) if arguments.write else None)


def _points(arguments: argparse.Namespace, loaded: LoadedRig, unit: str) -> list[ReferencePoint]:
    """In the order of --at. All that need the device are read while it is open."""
    from daemon.cli.devices.known_values import refuse_far_away
    from tuning.sensor_calibration.line_fit import ReferencePoint

    asked = [(text.partition("=")[0].strip(), text.partition("=")[2].strip()) for text in arguments.at]
    values = [_stated(value, unit) for value, _ in asked]
    refuse_far_away(loaded, arguments.sensor, arguments.at, values)
    if all(counts for _, counts in asked):
        return [ReferencePoint(value, _stated(counts, "")) for value, (_, counts) in zip(values, asked, strict=True)]
    return _read(arguments, loaded.rig.signals[arguments.sensor], values, asked)


def _stated(text: str, unit: str, option: str = "--at") -> float:
    """What a part of an option says."""
    from config.errors import UnitError
    from config.units import to_si

    try:
        return to_si(text, unit)
    except UnitError as error:
        parts = error.refusal
        raise UnitError(parts.what, value=parts.value, unit=parts.unit, where=option, next_step=parts.next_step) from error


def _read(arguments: argparse.Namespace, signal: AnySignal, values: list[float], asked: list[tuple[str, str]]) -> list[ReferencePoint]:
    from config.errors import UsageError
    from daemon.cli.devices.device_numbers import device
    from tuning.sensor_calibration.line_fit import ReferencePoint

    points = []
    with device(of_rig(arguments.rig, signal.device)) as opened:
        channel = [number.name for number in opened.numbers].index(signal.channel)
        for value, (text, counts) in zip(values, asked, strict=True):
            if counts:
                points.append(ReferencePoint(value, _stated(counts, "")))
                continue
            print(f"Bring {arguments.sensor} to {text}, hold it there, then press Enter.", file=sys.stderr, flush=True)
            if not sys.stdin.readline():
                advice = "Run it in a terminal, or give counts that were read before: --at VALUE=COUNTS."
                raise UsageError("no Enter came: nobody says that the sensor stands there", value=text, where="--at", next_step=advice)
            found = _readings(opened.source, channel, arguments, _watch(arguments, signal))
            sd = statistics.stdev(found) if len(found) > 1 else 0.0
            points.append(ReferencePoint(value, statistics.fmean(found), sd, len(found)))
            print(f"  {points[-1].counts:.6g} counts, standard deviation {sd:.3g}, {len(found)} readings", file=sys.stderr, flush=True)
    return points


def _watch(arguments: argparse.Namespace, signal: AnySignal) -> str:
    return shlex.join(["longreach", "device", "watch", arguments.rig, signal.device])


def _readings(source: Any, channel: int, arguments: argparse.Namespace, watch: str) -> list[float]:
    """As many as asked for. DriverError when the device gives none for that long."""
    from config.errors import DriverError

    missed = 0
    found: list[float] = []
    while len(found) < arguments.readings:
        value = source.read()[channel]
        if isinstance(value, float):
            found.append(value)
        else:
            missed += 1
        if missed > arguments.readings:
            advice = f"`{watch}` shows what it says."
            why = "; ".join(source.problems())
            raise DriverError("the device gives no readings", value=why, where=arguments.sensor, next_step=advice)
        time.sleep(arguments.every)
    return found


def _report(arguments: argparse.Namespace, found: SensorCalibration, loaded: LoadedRig, entry: str, unit: str, output: Path | None) -> None:
    if arguments.json:
        points = [
            {"value": point.value, "counts": point.counts, "sd": point.sd, "readings": point.readings, "residual": residual}
            for point, residual in zip(found.points, found.residuals, strict=True)
        ]
        numbers = {"scale": found.scale, "offset": found.offset, "noise": found.noise, "uncertainty": found.uncertainty, "unit": unit}
        print(json.dumps({"signal": arguments.sensor, **numbers, "points": points, "record": entry, "written": str(output or "") or None}))
        return
    print("\n".join(_table(arguments.sensor, found, loaded)))
    if loaded.rig.signals[arguments.sensor].calibration.scale * found.scale < 0:
        print("The sign turns.")
    if len(found.points) == 2:
        print("Two points always lie on a line: a third shows whether the sensor is straight.")
    if found.uncertainty is None:
        print("uncertainty: not known, and left out; next: a third --at, or --reference-uncertainty VALUE.")
    print(f"signals:\n  {arguments.sensor}:\n    calibration: {entry}")
    if output is None:
        print(f"not written; next: the same with --write, or -o FILE; then `longreach check {arguments.rig}`")
    else:
        print(f"written: {output}; next: longreach check {output}")


def _table(name: str, found: SensorCalibration, loaded: LoadedRig) -> list[str]:
    """The points, in the unit in which the file states the signal's range."""
    from config.loading.stated_units import stated_units
    from daemon.cli.devices.device_numbers import scaling
    from daemon.cli.shown.terminal import text_table

    before = scaling(name, loaded.rig.signals[name], stated_units(loaded.text))
    unit, factor, zero = before.shown
    rows = [
        [
            f"{factor * point.value + zero:.6g}",
            f"{point.counts:.8g}",
            f"{before.value(point.counts):.6g}",
            f"{factor * residual:.3g}",
            f"{point.sd:.3g}" if point.readings > 1 else "not measured",
        ]
        for point, residual in zip(found.points, found.residuals, strict=True)
    ]
    return text_table([f"known, {unit}", "counts", f"so far read as, {unit}", f"residual, {unit}", "sd, counts"], rows, left=())
