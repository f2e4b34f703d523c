"""Every command of `longreach`: its name, what it is for, and where it lives. Importing this imports none of them.

A command's file names its options in a function of the parser, and imports no more than the standard library while it does: `estop`
must not wait for another command's libraries, and the shell's completion asks for all options at once. What a command needs to do its
work it imports when it does it.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple, NoReturn

from config.errors import EXIT_USAGE, UsageError


class Command(NamedTuple):
    """`options`: "module:function" below daemon.cli; the function adds the options to the command's parser."""

    name: str
    options: str
    help: str


COMMANDS = (
    Command("demo", "demo.demo_command:options", "run the paper's maneuver on the simulated rig, unshaped and shaped, and report"),
    Command("check", "operate.check_command:options", "check a rig file, with no hardware"),
    Command("new-rig", "rigs.new_rig_command:options", "write a rig file for one hydraulic axis from its data sheets"),
    Command("status", "operate.status_commands:status_options", "what the daemon and the arm are doing now"),
    Command(
        "why", "operate.why_command:options", "why the arm will not move: the checks that fail, with value, limit, unit, source and age"
    ),
    Command("maneuvers", "operate.status_commands:maneuvers_options", "the maneuvers that this rig can run"),
    Command(
        "events",
        "operate.status_commands:events_options",
        "mode changes and what asked for them, interlocks and faults since the daemon started",
    ),
    Command("arm", "operate.arm_commands:arm_options", "run the arming checks and hold the present position"),
    Command("disarm", "operate.arm_commands:disarm_options", "safe outputs; motion needs a new `longreach arm`"),
    Command("reset", "operate.arm_commands:reset_options", "clear a latched fault or e-stop; ends disarmed"),
    Command("estop", "operate.arm_commands:estop_options", "safe outputs at once, latched until `longreach reset`"),
    Command("prove", "operate.prove_command:options", "prove the devices' safe state, with the pressure off"),
    Command("start", "operate.motion_commands:start_options", "run a maneuver, after a countdown"),
    Command("stop", "operate.motion_commands:stop_options", "controlled stop: decelerate along the path, then hold"),
    Command("jog", "jog.jog_command:options", "drive the arm by hand: it moves while an arrow key is held, and does not swing"),
    Command("ui", "live.ui_command:options", "a web page on loopback: live plots, checks, maneuvers; with --control also buttons"),
    Command("top", "live.top_command:options", "the rig at a glance in this terminal, until q"),
    Command("live", "live.foxglove_command:options", "live data for Foxglove, with the topics and the layout of the log"),
    Command("play", "live.play_command:options", "play a log into ui, top or live, at any speed"),
    Command("log", "logs.log_commands:log_verbs", "look at, check, repair, plot, compare or export a log"),
    Command("runs", "logs.runs_command:options", "the runs in a folder of logs: list, filter, find"),
    Command("import", "logs.import_command:options", "turn measured data from anywhere (CSV, MATLAB) into a log"),
    Command("replay", "logs.replay_command:options", "re-execute a log's controller and compare bit for bit"),
    Command(
        "design",
        "tune.design_command:options",
        "shape the rotary joint's compensator: stiffest with margins and link damping over the whole workspace",
    ),
    Command(
        "paper", "tune.paper_command:options", "compute the 1997 paper again: acceptance table, figures, misprints (exit 1: a row fails)"
    ),
    Command("gap", "gap.gap_command:verbs", "find the physics the model lacks, and prove it on a log that was not fitted"),
    Command(
        "identify",
        "tune.identify_command:options",
        "identify a rig: frequency responses, the link's map, the payload; writes a calibration record",
    ),
    Command(
        "shape",
        "tune.shape_command:options",
        "recommend a command filter for given moves: vibration left over a frequency error, and time cost, of every filter",
    ),
    Command(
        "warm-up",
        "tune.warm_up_command:warm_up_options",
        "warm the simulated rig up by its own work for five hours (Fig 2): plant and moves at its moments, with and without oil tables",
    ),
    Command(
        "oil-table",
        "tune.warm_up_command:oil_table_options",
        "the oil compensation of a joint from steady speeds on the simulated rig, as a change of the rig file",
    ),
    Command("simulate", "simulate.simulate_command:options", "run a maneuver on the simulated rig without a daemon, once or over a sweep"),
    Command("commission", "commission.commission_command:options", "from a rig file to its first shaped move, step by step, each recorded"),
    Command("version", "operate.version_command:options", "what is installed here: version, commit, Python, libraries"),
    Command("new-driver", "devices.new_driver_command:options", "write a plug-in package for a device of your own, with its tests"),
    Command("device", "devices.device_command:verbs", "find devices on a bus or line, read and watch them; what each driver can be told"),
    Command("completion", "completion_command:options", "print what makes a shell complete commands and options"),
    Command("host", "operate.host_command:options", "which rates the daemon keeps on this computer with a rig's devices, and why"),
    Command("service", "operate.service_command:verbs", "install this longreach as a systemd service, or remove it"),
    Command("twin", "operate.twin_command:options", "simulate a rig's CAN and Modbus devices"),
    Command("faults", "faults_command:options", "inject faults into the simulated rig and measure the time to safe"),
)


class Parser(argparse.ArgumentParser):
    """Words that do not fit are answered with the nearest that do, and with the command to type next."""

    _words: list[str]

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        self._words = sys.argv[1:] if args is None else list(args)
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        from daemon.cli.refusal import as_typed_here, error_object
        from daemon.cli.wrong_usage import wrong_usage

        wrong = wrong_usage(self, self._words, message)
        if "--json" in self._words:
            refusal = UsageError(wrong.said, where=wrong.of, next_step=f"Type `{wrong.typed}`.")
            print(json.dumps(error_object(refusal)))
            self.exit(EXIT_USAGE)
        usage = self.format_usage() if wrong.with_usage else ""
        self.exit(EXIT_USAGE, f"{usage}{wrong.of}: {wrong.said}\nnext: {as_typed_here(wrong.typed)}\n")


class CommandParser(Parser):
    """The parser of one command: its options are there once it parses, which it does only when the user named the command."""

    def __init__(self, *, options: str = "", **keywords: Any) -> None:
        super().__init__(**keywords)
        self._options = options

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        self.load()
        found, rest = super().parse_known_args(args, namespace)
        return found, self._with_optional_word(found, rest)

    def _with_optional_word(self, found: argparse.Namespace, rest: list[str]) -> list[str]:
        """The words that are left. argparse takes an optional word only beside the one before it, with no option between them."""
        for action in self._get_positional_actions():
            left_out = action.nargs == "?" and getattr(found, action.dest, None) is action.default
            if left_out and rest and not rest[0].startswith("-"):
                setattr(found, action.dest, self._read(action, rest[0]))
                rest = rest[1:]
        return rest

    def _read(self, action: argparse.Action, word: str) -> Any:
        try:
            return self._get_values(action, [word])
        except argparse.ArgumentError as error:
            self.error(str(error))

    def load(self) -> None:
        """Import the command and add its options, once."""
        place, self._options = self._options, ""
        if place:
            module, _, function = place.partition(":")
            add_options: Callable[[argparse.ArgumentParser], None] = getattr(import_module(f"daemon.cli.{module}"), function)
            add_options(self)


def add_commands(parser: argparse.ArgumentParser) -> None:
    """Every command as a sub-parser of `parser`, with no more than its name and its help."""
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=CommandParser)
    for command in COMMANDS:
        commands.add_parser(command.name, help=command.help, description=command.help, options=command.options)
