"""`gap find|next|demo`: where model and measurement disagree, what is missing, and which maneuver would tell."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from config.errors import ConfigError
from config.load import load_rig
from daemon.cli.connection import add_json_option


def register(commands: Any) -> None:
    gap = commands.add_parser("gap", help="find the physics the model lacks, and prove it on a log that was not fitted")
    verbs = gap.add_subparsers(dest="verb", required=True, metavar="VERB")
    _register_find(verbs)
    _register_next(verbs)
    _register_demo(verbs)


def _register_find(verbs: Any) -> None:
    parser = verbs.add_parser("find", help="compare logs with the rig file's plant; writes findings.json, rig.yaml and report.html")
    parser.add_argument("--rig", required=True, metavar="RIG.yaml", help="the rig file, or the name of a shipped rig")
    parser.add_argument("--log", type=Path, action="append", required=True, metavar="LOG", help="log to fit (MCAP or CSV); may be repeated")
    parser.add_argument(
        "--holdout", type=Path, action="append", default=[], metavar="LOG", help="log of another maneuver that decides; may be repeated"
    )
    parser.add_argument("--out", type=Path, default=Path("gap"), metavar="DIR", help="where the results go (default ./gap)")
    parser.add_argument("--window", type=float, metavar="S", help="length of the windows compared (default: by the kind of arm)")
    add_json_option(parser)
    parser.set_defaults(run_command=_find)


def _register_next(verbs: Any) -> None:
    parser = verbs.add_parser("next", help="which shipped maneuver separates two explanations best")
    parser.add_argument("--rig", required=True, metavar="RIG.yaml")
    parser.add_argument("--findings", type=Path, metavar="findings.json", help="the leading explanations of an earlier `gap find`")
    parser.add_argument(
        "--between", nargs=2, metavar="EFFECT@PLACE", help="two effects, e.g. coulomb_friction@rotary valve_deadband@rotary"
    )
    add_json_option(parser)
    parser.set_defaults(run_command=_next)


def _register_demo(verbs: Any) -> None:
    parser = verbs.add_parser("demo", help="hide an effect in the simulated rig, log two maneuvers, find it")
    parser.add_argument("--seed", type=int, default=1, help="chooses the hidden effect (default 1)")
    parser.add_argument("--out", type=Path, default=Path("gap-demo"), metavar="DIR")
    add_json_option(parser)
    parser.set_defaults(run_command=_demo)


def teller(quiet: bool) -> Callable[[str], None]:
    """Progress lines with the time so far, on stderr."""
    start = time.monotonic()

    def tell(line: str) -> None:
        if not quiet:
            print(f"{time.monotonic() - start:6.1f} s  {line}", file=sys.stderr, flush=True)

    return tell


def _find(arguments: argparse.Namespace) -> int:
    from gap.find import find  # slow to import; the other commands do without
    from gap.settings import Settings

    tell = teller(False)
    found = find(arguments.rig, arguments.log, arguments.holdout, arguments.out, tell, Settings(window_s=arguments.window))
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
    lines.append(f"written: {out / 'findings.json'}, {out / 'rig.yaml'}, {out / 'report.html'}")
    return "\n".join(lines)


def _next(arguments: argparse.Namespace) -> int:
    from gap.next_maneuver import propose, rival_of

    loaded = load_rig(arguments.rig)
    pairs = _explanations(arguments)
    rivals = [rival_of(loaded, effect, where, values) for effect, where, values in pairs]
    proposals = [p.as_dict() for p in propose(loaded, rivals[0], rivals[1], teller(arguments.json))]
    if arguments.json:
        print(json.dumps({"proposals": proposals}))
    elif not proposals:
        print("the rig allows none of the shipped maneuvers")
    else:
        print(f"{rivals[0].name} or {rivals[1].name}: run `{proposals[0]['name']}`: {proposals[0]['why']}")
    return 0


def _explanations(arguments: argparse.Namespace) -> list[tuple[str, str, dict[str, float]]]:
    """Two explanations: from --between, or the first finding of a file and its first look-alike."""
    if arguments.between:
        named = [word.partition("@") for word in arguments.between]
        return [(effect, where, {}) for effect, _, where in named]
    if not arguments.findings:
        raise ConfigError("nothing to separate", where="gap next", next_step="Give --findings findings.json or --between A@PLACE B@PLACE.")
    for item in json.loads(arguments.findings.read_text())["findings"]:
        for other in item["look_alikes"][:1]:
            values = {key: p["value"] for key, p in item["parameters"].items()}
            return [(item["effect"], item["where"], values), (other["effect"], other["where"], {})]
    advice = "Every finding stands alone. Use --between to compare two effects all the same."
    raise ConfigError("the findings hold no look-alikes", where=str(arguments.findings), next_step=advice)


def _demo(arguments: argparse.Namespace) -> int:
    from daemon.cli.gap_demo import run_demo

    return run_demo(arguments.seed, arguments.out, teller(arguments.json), arguments.json)
