"""`shape`: which command filter for these moves, from the rig's (or an identified) map of the link."""

from __future__ import annotations

import argparse
import dataclasses
import json
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import ConfigError
from daemon.cli.connection import add_json_option
from daemon.cli.operate.motion_commands import maneuver_text
from daemon.cli.options.numbers import finite
from daemon.cli.options.output_file import PICTURE
from daemon.cli.options.shaper import shaper_request
from daemon.cli.shown.progress import progress_lines
from daemon.cli.shown.shown_units import add_si_option, sentences_for, stated_refusals

if TYPE_CHECKING:
    from rich.table import Table

    from config.loading.load import LoadedRig
    from config.stated_sentences import StatedSentences
    from tuning.shaper_choice.shape_recommendation import Recommendation


def options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("rig", nargs="?", default="ornl_testbed", metavar="RIG", help="a rig file or the name of a shipped one")
    parser.add_argument("--maneuver", action="append", metavar="NAME", help="maneuver or file; may be repeated (default paper_line)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change the maneuvers, e.g. --set y0='30 in'")
    parser.add_argument("--record", type=Path, metavar="RECORD.yaml", help="use this calibration record's link instead of the rig file's")
    parser.add_argument(
        "--error", type=finite(0, 90, "%"), default=10.0, metavar="PERCENT", help="range of the frequency error (default ±10)"
    )
    parser.add_argument("--allowed", default="0.1 m/s^2", help="vibration allowed in the holds (default %(default)s)")
    parser.add_argument("--focal", default="mid", help="of fixed filters: initial, final, mid or a number in Hz (default mid)")
    parser.add_argument("--both-joints", action="store_true", help="filter both joints, so that the line stays straight")
    parser.add_argument("-o", "--output", type=PICTURE, metavar="PICTURE.png", help="draw residual over error")
    parser.add_argument("--ideal", action="store_true", help="judge on ideal joints; the runs are not simulated on the rig file's plant")
    add_si_option(parser)
    add_json_option(parser)
    parser.set_defaults(run_command=_shape)


def _shape(arguments: argparse.Namespace) -> int:
    from config.units import to_si
    from daemon.server.start_request import requested_maneuver
    from tuning.shaper_choice.shape_plot import shape_plot
    from tuning.shaper_choice.shape_recommendation import recommend

    loaded = _loaded(arguments)
    _refuse_without_link(loaded, arguments.rig)
    rig, sentences = loaded.rig, sentences_for(loaded.text, arguments.si)
    shaper = shaper_request(argparse.Namespace(**{**vars(arguments), "shaper": "none", "delay": None}), list(rig.joints))
    maneuvers = [requested_maneuver(maneuver_text(name), arguments.set)[0] for name in arguments.maneuver or ["paper_line"]]
    errors = tuple(arguments.error / 100.0 * share for share in (-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0))
    allowed_mps2 = to_si(arguments.allowed, "m/s^2")
    with stated_refusals(loaded.text, arguments.si or arguments.json):
        found = recommend(rig, maneuvers, shaper, allowed_mps2, errors, not arguments.ideal, progress_lines(arguments.json))
    if arguments.output:
        shape_plot(found, arguments.output)
    if arguments.json:
        print(json.dumps(_answer(found)))
    else:
        _show(found, arguments, sentences)
    return 0


def _refuse_without_link(loaded: LoadedRig, named: str) -> None:
    if loaded.rig.link_mode is None:
        advice = f"A link that does not swing needs no filter; for one that does, add link_mode. `longreach check {shlex.quote(named)}`"
        raise ConfigError("the rig file has no link_mode: no vibration to filter", where=loaded.path, next_step=f"{advice} shows the rig.")


def _show(found: Recommendation, arguments: argparse.Namespace, sentences: StatedSentences) -> None:
    from daemon.cli.shown.rich_console import console

    console().print(_table(found, arguments.error))
    for each in found.candidates:
        if each.refused:
            print(f"{each.kind} cannot be used: {sentences.text(each.refused)}")
    if left_out := found.best.judged.too_short:
        print(f"not judged, because the hold ends before the vibration could be seen: {', '.join(left_out)}; next: --set hold=3s")
    print(found.why)
    if found.best.tip is not None:
        print(f"with it {sentences.text(found.best.tip.text())}")
    both = " --both-joints" if arguments.both_joints else ""
    print(f"next: longreach start {(arguments.maneuver or ['paper_line'])[0]} --shaper {found.chosen}{both}")


def _answer(found: Recommendation) -> dict[str, Any]:
    return {
        "chosen": found.chosen,
        "why": found.why,
        "allowed_mps2": found.allowed_mps2,
        "filters": [{**dataclasses.asdict(each), "worst_dB": found.decibels(each)} for each in found.candidates if not each.refused],
        "refused": {each.kind: each.refused for each in found.candidates if each.refused},
    }


def _loaded(arguments: argparse.Namespace) -> LoadedRig:
    from config.loading.identified import with_identified
    from config.loading.load import LoadedRig, apply_overrides, load_rig, rig_from_text

    loaded = load_rig(arguments.rig)
    if arguments.record is None:
        return loaded
    text = apply_overrides(loaded.text, [f"identified={{record: {json.dumps(str(arguments.record.absolute()))}}}"])
    text = with_identified(text, Path(loaded.path))
    return LoadedRig(rig_from_text(text, loaded.path), text, loaded.path)


def _table(found: Recommendation, percent: float) -> Table:
    """Filters that can be used; without error and worst over the errors, on ideal joints and on the whole rig."""
    from rich.table import Table

    usable = [each for each in found.candidates if not each.refused]
    coupled = any(each.coupled is not None for each in usable)
    title = f"vibration left 1.0 s after the moves, m/s²; worst: within ±{percent:g} % of the frequency"
    table = Table(title=title, title_justify="left", header_style="bold")
    for heading in ("filter", "ideal joints", "worst", *(["whole rig", "worst"] if coupled else []), "dB", "later, s"):
        table.add_column(heading, justify="left" if heading == "filter" else "right")
    for each in usable:
        parts = [part for part in (each.ideal, each.coupled) if part is not None]
        numbers = [f"{value:.3f}" for part in parts for value in (part.nominal_mps2, part.worst_mps2)]
        style = "bold" if each.kind == found.chosen else None
        table.add_row(each.kind, *numbers, f"{found.decibels(each):+.1f}", f"{each.judged.late_s:.2f}", style=style)
    return table
