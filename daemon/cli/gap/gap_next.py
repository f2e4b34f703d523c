"""`gap next`: the maneuver that separates explanations soonest, or the sensor that would."""

from __future__ import annotations

import argparse
import json
import shlex
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from config.errors import ConfigError, LogError, UsageError
from daemon.cli.connection import add_json_option
from daemon.cli.shown.progress import progress_lines

if TYPE_CHECKING:
    from config.loading.load import LoadedRig
    from config.schema.rig import Rig
    from gap.maneuvers.separation import Rival

_PARTS = {"findings", "gap", "parameters"}  # of findings.json, that are needed here


def register(verbs: Any) -> None:
    parser = verbs.add_parser("next", help="which maneuver separates explanations soonest, or which sensor would")
    parser.add_argument("--rig", required=True, metavar="RIG.yaml", help="the rig file, or the name of a shipped rig")
    parser.add_argument("--findings", type=Path, metavar="findings.json", help="the leading explanations of an earlier `gap find`")
    parser.add_argument(
        "--between",
        nargs="+",
        metavar="EFFECT@PLACE",
        help="two or more effects, e.g. coulomb_friction@rotary valve_deadband@rotary; `none` stands for no missing effect",
    )
    parser.add_argument(
        "--log",
        type=Path,
        action="append",
        default=[],
        metavar="LOG",
        help="logs that the explanations were fitted to: what these hold, no explanation can move to look like another",
    )
    add_json_option(parser)
    parser.set_defaults(run_command=_next)


def _next(arguments: argparse.Namespace) -> int:
    from config.loading.load import load_rig
    from gap.data.measured import load
    from gap.maneuvers.informed import informed
    from gap.maneuvers.next_maneuver import next_maneuver

    loaded = load_rig(arguments.rig)
    content = _content(arguments.findings, loaded.rig.name) if arguments.findings else {}
    measured = list(content["gap"]["channels"]) if content else None
    rivals = _explanations(loaded, arguments, content)
    if arguments.log:
        rivals = informed(loaded, rivals, [load(path, loaded.rig) for path in arguments.log])
    proposal = next_maneuver(loaded, rivals, progress_lines(arguments.json), measured)
    if arguments.json:
        print(json.dumps({"proposal": proposal.as_dict() if proposal else None}))
    elif proposal is None:
        print("the rig allows none of the shipped maneuvers")
    else:
        print(advice(proposal.as_dict()))
    return 0


def _content(path: Path, rig_name: str) -> dict[str, Any]:
    """LogError for a file that is no findings.json, or one of another rig: it is data, and not usable."""
    from config.loading.load import read_text

    content: Any = None
    with suppress(ValueError):
        content = json.loads(read_text(path))
    if not (isinstance(content, dict) and content.keys() >= _PARTS):
        advice = "`longreach gap find --help` says which command writes one."
        raise LogError("this is no findings.json", where=str(path), next_step=advice)
    found_on = content.get("rig", rig_name)  # earlier versions did not write it
    if found_on != rig_name:
        advice = f"Give --rig with the file of {found_on}, or the findings of {rig_name}."
        raise LogError("the findings are of another rig", value=found_on, limit=rig_name, where=str(path), next_step=advice)
    return content


def advice(proposal: dict[str, Any]) -> str:
    """What to run, how, and what to expect of it."""
    them = " or ".join(proposal["separates"])
    if not proposal["repeats"]:
        return f"{them}: {proposal['why']}"
    each = [_expected(pair) for pair in proposal["pairs"]] if len(proposal["pairs"]) > 1 else []
    changes = " ".join(f"--set {key}='{_word(value)}'" for key, value in proposal["parameters"].items())
    command = f"  longreach start {proposal['name']} --approach {changes}".rstrip()
    return "\n".join([f"{them}: {proposal['why']}", *each, command])


def _expected(pair: dict[str, Any]) -> str:
    names = " or ".join(pair["between"])
    return f"  {names}: expected t {pair['expected_t']:.1f}" if pair["repeats"] else f"  {names}: not told apart"


def _word(value: Any) -> str:
    return "{" + ", ".join(f"{k}: {v}" for k, v in value.items()) + "}" if isinstance(value, dict) else str(value)


def _explanations(loaded: LoadedRig, arguments: argparse.Namespace, content: dict[str, Any]) -> list[Rival]:
    """From --between, else the finding in doubt and what it is hard to tell from."""
    from gap.maneuvers.rivals import MOST_RIVALS, no_effect, rival_of
    from gap.outcome.findings import explanations

    if arguments.between:
        return _given(loaded, arguments.between)
    if not content:
        advice = f"Give --findings findings.json, or two effects: `{_with_two_effects(loaded.rig, arguments.rig)}`."
        raise ConfigError("nothing to separate", where="gap next", next_step=advice)
    findings = _effects(explanations(content))  # a number that has changed stands among the constants
    doubtful = [item for item in findings if _effects(item["look_alikes"])] or [item for item in findings if not item["confirmed"]]
    if not doubtful:
        advice = f"Every finding stands alone. Two effects all the same: `{_with_two_effects(loaded.rig, arguments.rig)}`."
        raise ConfigError("the findings leave nothing in doubt", where=str(arguments.findings), next_step=advice)
    base = no_effect(loaded, {key: item["value"] for key, item in content["parameters"].items()})
    for item in findings:
        if item is not doubtful[0]:
            base = rival_of(loaded, item["effect"], item["where"], _values(item), base)
    alike = [doubtful[0], *_effects(doubtful[0]["look_alikes"])][:MOST_RIVALS]
    found = [rival_of(loaded, item["effect"], item["where"], _values(item), base) for item in alike]
    return found if len(found) > 1 else [*found, base]


def _with_two_effects(rig: Rig, path: str) -> str:
    """The command with two effects that the rig file lacks, at its first joint."""
    from gap.maneuvers.rivals import addable

    joint = next(iter(rig.joints))
    one, other, *_ = (c.effect for c in addable(rig) if c.where == joint)
    return f"longreach gap next --rig {shlex.quote(path)} --between {one}@{joint} {other}@{joint}"


def _given(loaded: LoadedRig, between: Sequence[str]) -> list[Rival]:
    """The effects named, each made as like the first as it can be."""
    from gap.maneuvers.designs import designs
    from gap.maneuvers.matching import matched
    from gap.maneuvers.rivals import no_effect, rival_of

    if len(set(between)) < 2:
        raise UsageError("one explanation cannot be told from itself", value=between[0], where="--between", next_step="Give two or more.")
    named = [word.partition("@") for word in between]
    first, *others = (no_effect(loaded) if effect == "none" else rival_of(loaded, effect, where) for effect, _, where in named)
    forms = designs(loaded.rig, list(loaded.rig.joints), thorough=False)
    return [first, *(matched(loaded, first, other, forms) for other in others)]


def _effects(items: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Those that the rig file lacks."""
    return [item for item in items if "stated" not in item]


def _values(item: dict[str, Any]) -> dict[str, float]:
    return {key: parameter["value"] for key, parameter in item["parameters"].items()}
