"""`gap next`: the maneuver that separates two explanations soonest, or the sensor that would."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import ConfigError
from config.load import LoadedRig, load_rig
from daemon.cli.connection import add_json_option
from daemon.cli.progress import teller

if TYPE_CHECKING:
    from gap.separation import Rival


def register(verbs: Any) -> None:
    parser = verbs.add_parser("next", help="which maneuver separates two explanations soonest, or which sensor would")
    parser.add_argument("--rig", required=True, metavar="RIG.yaml", help="the rig file, or the name of a shipped rig")
    parser.add_argument("--findings", type=Path, metavar="findings.json", help="the leading explanations of an earlier `gap find`")
    parser.add_argument(
        "--between",
        nargs=2,
        metavar="EFFECT@PLACE",
        help="two effects, e.g. coulomb_friction@rotary valve_deadband@rotary; `none` stands for no missing effect",
    )
    add_json_option(parser)
    parser.set_defaults(run_command=_next)


def _next(arguments: argparse.Namespace) -> int:
    from gap.next_maneuver import next_maneuver  # slow to import; the other commands do without

    loaded = load_rig(arguments.rig)
    content = json.loads(arguments.findings.read_text()) if arguments.findings else {}
    measured = list(content["gap"]["channels"]) if content else None
    first, second = _explanations(loaded, arguments.between, content, str(arguments.findings))
    proposal = next_maneuver(loaded, first, second, teller(arguments.json), measured)
    if arguments.json:
        print(json.dumps({"proposal": proposal.as_dict() if proposal else None}))
    elif proposal is None:
        print("the rig allows none of the shipped maneuvers")
    else:
        print(advice(proposal.as_dict()))
    return 0


def advice(proposal: dict[str, Any]) -> str:
    """What to run, how, and what to expect of it."""
    pair = " or ".join(proposal["separates"])
    if not proposal["repeats"]:
        return f"{pair}: {proposal['why']}"
    changes = " ".join(f"--set {key}='{_word(value)}'" for key, value in proposal["parameters"].items())
    return f"{pair}: {proposal['why']}\n  longreach start {proposal['name']} --approach {changes}".rstrip()


def _word(value: Any) -> str:
    return "{" + ", ".join(f"{k}: {v}" for k, v in value.items()) + "}" if isinstance(value, dict) else str(value)


def _explanations(loaded: LoadedRig, between: Sequence[str] | None, content: dict[str, Any], path: str) -> tuple[Rival, Rival]:
    """From --between, else the finding in doubt and what it is hard to tell from."""
    from gap.designs import designs
    from gap.matching import matched
    from gap.next_maneuver import no_effect, rival_of

    if between:
        named = [word.partition("@") for word in between]
        first, second = (no_effect(loaded) if effect == "none" else rival_of(loaded, effect, where) for effect, _, where in named)
        return first, matched(loaded, first, second, designs(loaded.rig, list(loaded.rig.joints), thorough=False))
    if not content:
        raise ConfigError("nothing to separate", where="gap next", next_step="Give --findings findings.json or --between A@PLACE B@PLACE.")
    constants = {key: item["value"] for key, item in content["parameters"].items()}
    doubtful = [item for item in content["findings"] if item["look_alikes"]] or [i for i in content["findings"] if not i["confirmed"]]
    if not doubtful:
        advice = "Every finding stands alone. Use --between to compare two effects all the same."
        raise ConfigError("the findings leave nothing in doubt", where=path, next_step=advice)
    chosen, others = doubtful[0], doubtful[0]["look_alikes"]
    rival = _rival(loaded, others[0], constants) if others else no_effect(loaded, constants)
    return _rival(loaded, chosen, constants), rival


def _rival(loaded: LoadedRig, item: dict[str, Any], constants: dict[str, float]) -> Rival:
    from gap.next_maneuver import rival_of

    values = {key: parameter["value"] for key, parameter in item["parameters"].items()}
    return rival_of(loaded, item["effect"], item["where"], values, constants)
