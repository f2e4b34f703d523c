"""`gap find|next|loop|study|watch|demo`: where model and measurement disagree, what is missing, and which maneuver would tell."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from daemon.cli.connection import add_json_option
from daemon.cli.gap import gap_demo, gap_loop, gap_next, gap_study, gap_watch
from daemon.cli.gap.gap_next import advice
from daemon.cli.options.numbers import finite
from daemon.cli.shown.progress import progress_lines
from daemon.cli.shown.shown_units import add_si_option

if TYPE_CHECKING:
    from gap.outcome.found import Found


def verbs(gap: argparse.ArgumentParser) -> None:
    found = gap.add_subparsers(dest="verb", required=True, metavar="VERB")
    _register_find(found)
    gap_next.register(found)
    gap_loop.register(found)
    gap_study.register(found)
    gap_watch.register(found)
    gap_demo.register(found)


def _register_find(verbs: Any) -> None:
    parser = verbs.add_parser("find", help="compare logs with the rig file's plant; writes findings.json, rig.yaml and report.html")
    parser.add_argument("--rig", required=True, metavar="RIG.yaml", help="the rig file, or the name of a shipped rig")
    _log_options(parser)
    parser.add_argument("--out", type=Path, default=Path("gap-found"), metavar="DIR", help="where the results go (default ./gap-found)")
    parser.add_argument(
        "--window", type=finite(0.01, 3600, "s"), metavar="S", help="length of the windows compared (default: by the kind of arm)"
    )
    parser.add_argument(
        "--request",
        type=Path,
        metavar="FILE",
        help="maneuver file, or run request (JSON), of the first hold-out: what the report runs again when a table does not say",
    )
    parser.add_argument(
        "--keep-remainder", action="store_true",
        help="put what has no name into rig.yaml as a table of forces or friction (unnamed_remainder), if the hold-out falls with it",
    )  # fmt: skip
    parser.add_argument("--no-next", action="store_true", help="do not look for a maneuver that would tell look-alikes apart (minutes)")
    add_si_option(parser)
    add_json_option(parser)
    parser.set_defaults(run_command=_find)


def _log_options(parser: argparse.ArgumentParser) -> None:
    logs: dict[str, Any] = {"type": Path, "action": "append", "metavar": "LOG"}
    fitted = "log to fit (MCAP, CSV or MAT; LOG@FROM:TO for a part, in s); may be repeated"
    parser.add_argument("--log", required=True, help=fitted, **logs)
    parser.add_argument("--holdout", default=[], help="log of another maneuver that judges; may be repeated", **logs)
    parser.add_argument("--unused", default=[], help="log that is neither fitted nor judges: the result is tried on it", **logs)


def _find(arguments: argparse.Namespace) -> int:
    from gap.find import find
    from gap.settings import Settings

    progress = progress_lines(False)
    settings = Settings(
        window_s=arguments.window,
        request=arguments.request,
        keep_remainder=arguments.keep_remainder,
        propose=not arguments.no_next,
        si=arguments.si,
    )
    found = find(arguments.rig, arguments.log, arguments.holdout, arguments.out, progress, settings, arguments.unused)
    print(json.dumps(found.content) if arguments.json else summary(found, arguments.out, arguments.si))
    return 0


def summary(found: Found, out: Path, si: bool = False) -> str:
    """What a reader at the terminal needs, in the units of the rig file."""
    from gap.outcome.file_units import FileUnits
    from gap.report.headline import bars, gap_line, grade, held_lines, lead_line, look_alikes, pulled_lines, values, zero_lines
    from gap.report.kept_sentence import kept_sentence

    content, units = found.content, FileUnits(found.rig.text, si)
    lines = [f"verdict: {content['verdict']}", units.sentences.text(content["why"]), *zero_lines(content, units)]
    for item in content["findings"]:
        alike = f"; look-alikes: {look_alikes(item)}" if item["look_alikes"] else ""
        lines.append(f"  {item['effect']} at {item['where']} ({grade(item, units)}): {values(item, units)}; t {item['t']:.1f}{alike}")
    lines += [lead_line(item, units) for item in content["leads"]]
    lines += [
        gap_line(content),
        *bars(content, units),
        *pulled_lines(content, units),
        *held_lines(content, units),
    ]
    if content["remainder"] and content["remainder"]["kept"]:
        lines.append(units.sentences.text(kept_sentence(content["remainder"])))
    lines += [f"never used: {x['file']}: {x['before']:.4g} → {x['after']:.4g} noise floors" for x in content["unused_logs"]]
    if content["next_maneuver"]:
        lines.append(advice(content["next_maneuver"]))
    lines.append(f"written: {out / 'findings.json'}, {out / 'rig.yaml'}, {out / 'report.html'}")
    return "\n".join(lines)
