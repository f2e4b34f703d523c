"""`warm-up`: five hours of the machine's own work on the simulated rig, and what they do to joints and feed-forward; `oil-table`."""

from __future__ import annotations

import argparse
import dataclasses
import json
from math import degrees
from typing import TYPE_CHECKING, Any

from config.errors import ConfigError
from daemon.cli.connection import add_json_option
from daemon.cli.options.numbers import finite, several
from daemon.cli.options.output_file import PICTURE
from daemon.cli.shown.progress import progress_lines

if TYPE_CHECKING:
    from rich.table import Table


OIL_C = (-20.0, 90.0)  # as of a plant's initial_temperature
FIRST = "22 degC"


def warm_up_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("rig", nargs="?", default="ornl_testbed", metavar="RIG", help="a rig file or the name of a shipped one")
    parser.add_argument("--hours", type=finite(0.5, 24, "h"), help="of the schedule (default: all five)")
    parser.add_argument("--start", default=FIRST, help="of everything at first (default %(default)s)")
    moments_help = "when to identify and to move, e.g. '0, 2.5, 5' (default: start, middle, end)"
    parser.add_argument("--moments", type=several(finite(0, 24, "h")), metavar="HOURS", help=moments_help)
    parser.add_argument("--maneuver", default="paper_line", help="the move, with the adaptive filter on both joints (default paper_line)")
    parser.add_argument("-o", "--output", type=PICTURE, metavar="PICTURE.png", help="draw it")
    add_json_option(parser)
    parser.set_defaults(run_command=_warm_up)


def oil_table_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("rig", nargs="?", default="ornl_testbed", metavar="RIG", help="a rig file or the name of a shipped one")
    parser.add_argument("--joint", default="prismatic", help="(default prismatic)")
    oil, usual = several(finite(*OIL_C, "degC")), "20, 30, 40, 50, 60, 70"
    parser.add_argument("--temperatures", type=oil, default=usual, metavar="LIST", help="degC (default %(default)s)")
    add_json_option(parser)
    parser.set_defaults(run_command=_oil_table)


def _warm_up(arguments: argparse.Namespace) -> int:
    from config.loading.load import load_rig
    from daemon.cli.shown.rich_console import console
    from tuning.oil.warm_up_plot import warm_up_plot
    from tuning.oil.warm_up_study import warm_up_study

    hours, moments = _schedule(arguments)
    rig, start_C = load_rig(arguments.rig).rig, _start_C(arguments.start)
    seconds = [3600.0 * moment for moment in moments]
    study = warm_up_study(rig, seconds, arguments.maneuver, hours, start_C, progress_lines(arguments.json))
    if arguments.output:
        warm_up_plot(study, arguments.output)
    if arguments.json:
        print(json.dumps(_numbers_of(study)))
        return 0
    console().print(_table(study))
    for joint in rig.joints:
        if rig.servo[joint].oil_compensation is None:
            print(f"{joint} has no oil compensation: longreach oil-table {arguments.rig} --joint {joint}")
    return 0


def _schedule(arguments: argparse.Namespace) -> tuple[float, list[float]]:
    """Its length and the moments to identify and move at, in hours."""
    from tuning.experiments.five_hours import HOURS

    hours = HOURS if arguments.hours is None else arguments.hours
    moments = arguments.moments or [0.0, 0.5 * hours, hours]
    outside = next((moment for moment in moments if not 0.0 <= moment <= hours), None)
    if outside is not None:
        what, without, limit = "a moment lies outside the schedule", {"--moments": None}, f"0 to {hours:g}"
        raise ConfigError(what, value=outside, limit=limit, unit="h", where="--moments", mend=without)
    return hours, moments


def _start_C(text: str) -> float:
    from config.units import to_si

    start_C, (low, high) = to_si(text, "degC"), OIL_C
    if not low <= start_C <= high:
        limit = f"{low:g} to {high:g} degC"
        raise ConfigError("the oil cannot be that warm or cold", value=text, limit=limit, where="--start", mend={"--start": FIRST})
    return start_C


def _oil_table(arguments: argparse.Namespace) -> int:
    from config.loading.load import load_rig
    from tuning.oil.oil_table import as_override, oil_table

    rig = load_rig(arguments.rig).rig
    if arguments.joint not in rig.joints:
        mend = {"--joint": next(iter(rig.joints))}
        raise ConfigError("unknown joint", value=arguments.joint, limit=", ".join(rig.joints), where="--joint", mend=mend)
    rows = oil_table(rig, arguments.joint, arguments.temperatures)
    source = f"{arguments.joint}.return_temperature"
    override = as_override(rig, arguments.joint, source, rows)
    if arguments.json:
        print(json.dumps({"joint": arguments.joint, "rows": [dataclasses.asdict(row) for row in rows], "override": override}))
    else:
        print(f"--set {override!r}")
    return 0


def _table(study: Any) -> Table:
    from rich.table import Table

    moments = study.moments
    table = Table(header_style="bold")
    table.add_column("after")
    for each in moments:
        table.add_column(f"{each.t_s / 3600.0:.2f} h", justify="right")
    table.add_row("reservoir, °C", *(f"{each.reservoir_C:.1f}" for each in moments))
    table.add_row("oil in the actuators, °C", *(f"{each.oil_C:.1f}" for each in moments))
    table.add_row("rotary gain at 0.1 V, 0.5 Hz, against 40 °C", *(f"{100.0 * (each.small_gain - 1.0):+.0f} %" for each in moments))
    table.add_row("Eq 4 at 0.3 V: K/b, °/s/V", *(f"{each.eq4.velocity_gain:.1f}" for each in moments))
    table.add_row("  frequency, Hz, and damping", *(f"{each.eq4.frequency_Hz:.1f}, {each.eq4.damping_ratio:.2f}" for each in moments))
    for joint in moments[0].rate_share["with"]:
        for name in ("without", "with"):
            shares = (_pair(each.rate_share[name][joint]) for each in moments)
            table.add_row(f"{joint} rate over the one asked for, forth / back, {name} table", *shares)
    for column, (joint, scaled, digits) in enumerate((("rotary, °", degrees, 3), ("prismatic, mm", _millimetres, 2))):
        for name in ("without", "with"):
            errors = (f"{scaled(each.lag[name].rms[column]):.{digits}f}" for each in moments)
            table.add_row(f"{study.maneuver}, rms error of {joint}, {name} table", *errors)
    return table


def _millimetres(metres: float) -> float:
    return 1e3 * metres


def _pair(shares: tuple[float, float]) -> str:
    return f"{shares[0]:.2f} / {shares[1]:.2f}"


def _numbers_of(study: Any) -> dict[str, Any]:
    """Everything that was found; the five hours as means of every minute, `t_s` its end."""
    ran = study.ran
    names = ("flow", "reservoir_C", "supply_C", "return_C", "metal_C")
    columns = {name: getattr(ran, name).reshape(-1, 60).mean(axis=1).tolist() for name in names}
    columns["t_s"] = ran.t_s[59::60].tolist()
    moments = []
    for each in study.moments:
        plain = {name: getattr(each, name) for name in ("t_s", "reservoir_C", "oil_C", "small_gain", "rate_share")}
        lags = {name: dataclasses.asdict(lag) for name, lag in each.lag.items()}
        response = [[value.real, value.imag] for value in each.response.tolist()]
        moments.append({**plain, "eq4": dataclasses.asdict(each.eq4), "response": response, "lag": lags})
    return {"maneuver": study.maneuver, "five_hours": columns, "moments": moments}
