"""`gap find|next|loop|study|demo`: where model and measurement disagree, what is missing, and which maneuver would tell."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from daemon.cli import gap_demo, gap_loop, gap_next, gap_study
from daemon.cli.connection import add_json_option
from daemon.cli.gap_next import advice
from daemon.cli.progress import teller
from gap.report.kept_sentence import kept_sentence


def register(commands: Any) -> None:
    gap = commands.add_parser("gap", help="find the physics the model lacks, and prove it on a log that was not fitted")
    verbs = gap.add_subparsers(dest="verb", required=True, metavar="VERB")
    _register_find(verbs)
    gap_next.register(verbs)
    gap_loop.register(verbs)
    gap_study.register(verbs)
    gap_demo.register(verbs)


def _register_find(verbs: Any) -> None:
    parser = verbs.add_parser("find", help="compare logs with the rig file's plant; writes findings.json, rig.yaml and report.html")
    parser.add_argument("--rig", required=True, metavar="RIG.yaml", help="the rig file, or the name of a shipped rig")
    parser.add_argument("--log", type=Path, action="append", required=True, metavar="LOG", help="log to fit (MCAP or CSV); may be repeated")
    parser.add_argument(
        "--holdout", type=Path, action="append", default=[], metavar="LOG", help="log of another maneuver that decides; may be repeated"
    )
    parser.add_argument(
        "--unused", type=Path, action="append", default=[], metavar="LOG", help="log that neither fits nor decides: judged at the end"
    )
    parser.add_argument("--out", type=Path, default=Path("gap"), metavar="DIR", help="where the results go (default ./gap)")
    parser.add_argument("--window", type=float, metavar="S", help="length of the windows compared (default: by the kind of arm)")
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
    add_json_option(parser)
    parser.set_defaults(run_command=_find)


def _find(arguments: argparse.Namespace) -> int:
    from gap.find import find  # slow to import; the other commands do without
    from gap.search.settings import Settings

    tell = teller(False)
    settings = Settings(window_s=arguments.window, request=arguments.request, keep_remainder=arguments.keep_remainder)
    found = find(arguments.rig, arguments.log, arguments.holdout, arguments.out, tell, settings, arguments.unused)
    print(json.dumps(found.content) if arguments.json else summary(found.content, arguments.out))
    return 0


def summary(content: dict[str, Any], out: Path) -> str:
    """What a reader at the terminal needs."""
    gap = content["gap"]
    lines = [f"verdict: {content['verdict']}", content["why"]]
    for item in content["findings"]:
        values = ", ".join(
            f"{key} {p['value']:g} {p['unit']} ({p['ci95'][0]:.4g} to {p['ci95'][1]:.4g})" for key, p in item["parameters"].items()
        )
        alike = f"; look-alikes: {', '.join(x['effect'] for x in item['look_alikes'])}" if item["look_alikes"] else ""
        grade = "confirmed" if item["confirmed"] else "tentative"
        lines.append(f"  {item['effect']} at {item['where']} ({grade}): {values}; t {item['t']:.1f}{alike}")
    lines.append(
        f"hold-out: {gap['holdout_before']:.4g} → {gap['holdout_refit']:.4g} (constants) → {gap['holdout_after']:.4g} noise floors"
    )
    if content["remainder"] and content["remainder"]["kept"]:
        lines.append(kept_sentence(content["remainder"]))
    lines += [f"never used: {x['file']}: {x['before']:.4g} → {x['after']:.4g} noise floors" for x in content["unused_logs"]]
    if content["next_maneuver"]:
        lines.append(advice(content["next_maneuver"]))
    lines.append(f"written: {out / 'findings.json'}, {out / 'rig.yaml'}, {out / 'report.html'}")
    return "\n".join(lines)
