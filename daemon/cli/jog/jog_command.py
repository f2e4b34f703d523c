"""`jog`: drive the arm with the arrow keys. It moves only while a key repeats; every key that is none of these stops it."""

from __future__ import annotations

import argparse
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from config.errors import DaemonError
from config.readable import number
from daemon.cli.connection import add_json_option, ask_to_stop, connect, show
from daemon.cli.jog.steering import DEAD_MAN_S, FIRST_SPEED, SteeredMotion, Steering, keys_of
from daemon.cli.options.countdown import add_countdown_option
from daemon.cli.options.numbers import finite
from daemon.cli.shown.shown_units import add_si_option, units_of_rig
from daemon.cli.shown.terminal import LiveScreen, coloured

if TYPE_CHECKING:
    from daemon.cli.jog.keyboard import Key, Keyboard
    from daemon.server.protocol import Client
    from daemon.server.stated_values import Units
    from daemon.server.stream_client import Stream

PERIOD_S = 0.02
SCREEN_S = 0.1
END_KEYS, ESTOP_KEYS = ("q", "\x03", "\x04"), ("e", "E")
RIG_FILTER = "rig"
FILTERS = (RIG_FILTER, "none", "zv", "zvd", "ei", "two_hump_ei", "adaptive", "adaptive_zv")
_EPILOG = f"""\
Arrow keys move, + and - change the speed, t changes between joints and tip, e is the e-stop, q ends; any other key stops at once. The
arm moves while a key repeats and slows down {1000 * DEAD_MAN_S:.0f} ms after the last one. The filter "rig" follows the link's
frequency, as far as the rig file knows it, so that the arm does not swing. See docs/guide/operate/drive-by-hand.md.
"""


def options(jog: argparse.ArgumentParser) -> None:
    jog.epilog = _EPILOG
    jog.add_argument("--tip", action="store_true", help="begin with the tip in the plane, not with the joints")
    jog.add_argument(
        "--speed", type=finite(1, 100, "%"), default=100.0 * FIRST_SPEED, metavar="PERCENT", help="of the limits, at first (default 10)"
    )
    jog.add_argument("--shaper", default=RIG_FILTER, choices=FILTERS, help="command filter of all joints (default: the rig's)")
    add_countdown_option(jog)
    add_si_option(jog)
    add_json_option(jog)
    jog.set_defaults(run_command=_jog)


def _jog(arguments: argparse.Namespace) -> int:
    """Exit 0 when q ended it, 1 when the daemon did."""
    from daemon.cli.jog.keyboard import Keyboard
    from daemon.server.stream_client import Stream

    with connect(arguments) as client, Keyboard() as keyboard:
        joints = list(client.call("status")["joints"])
        shaper = None if arguments.shaper == RIG_FILTER else {"kind": arguments.shaper, "joints": joints}
        stream = Stream(client, shaper, arguments.countdown)
        driver = _Driver(
            client, stream, Steering(stream.answer, arguments.tip, 0.01 * arguments.speed), units_of_rig(arguments, client.call)
        )
        with suppress(DaemonError):  # the run is over: why stands in its result
            driver.until_ended(keyboard)
        result = _ended(arguments, stream, keyboard, driver.estop_asked)
    show(arguments, result, f"run {result['run']}: {result['validity']}" + (f", because {result['reason']}" if result["reason"] else ""))
    return 0 if result["validity"] == "valid" else 1


def _ended(arguments: argparse.Namespace, stream: Stream, keyboard: Keyboard, estop_asked: bool) -> dict[str, Any]:
    """How the run ended. The e-stop key works until the arm rests; over a connection of its own, since the other one waits."""
    if estop_asked:
        ask_to_stop(arguments, "estop", "e-stop")
    with ThreadPoolExecutor(1) as waiting:
        result = waiting.submit(stream.end)
        while not result.done():
            with suppress(EOFError):
                if any(map(_is_estop, keyboard.keys(PERIOD_S))):
                    _stop_now(arguments)
        return result.result()


def _stop_now(arguments: argparse.Namespace) -> None:
    """A failure is told at once; the end of the run is still waited for."""
    try:
        ask_to_stop(arguments, "estop", "e-stop")
    except DaemonError as error:
        print(f"longreach: {error}", file=sys.stderr, flush=True)


def _is_estop(key: Key) -> bool:
    return key.name in ESTOP_KEYS and not key.released


class _Driver:
    """From keys to set points, fifty times a second, and what is shown meanwhile."""

    def __init__(self, client: Client, stream: Stream, steering: Steering, units: Units) -> None:
        self._client, self._stream, self._steering, self._units = client, stream, steering, units
        self._shown_s = 0.0
        self.estop_asked = False

    def until_ended(self, keyboard: Keyboard) -> None:
        """Until an end key or the e-stop. DaemonError when the daemon ends the run."""
        with LiveScreen() as screen:
            while True:
                keys = keyboard.keys(PERIOD_S)
                if any(map(_is_estop, keys)):  # before whatever came with it
                    self.estop_asked = True
                    return
                for key in keys:
                    if key.released:
                        self._steering.release(key.name)
                    elif key.name in END_KEYS:
                        return
                    else:
                        self._steering.press(key.name, time.monotonic())
                motion = self._steering.motion(time.monotonic())
                self._send(motion)
                self._show(screen, motion)

    def _send(self, motion: SteeredMotion) -> None:
        if motion.tip_mps is not None:
            self._stream.tip(*motion.tip_mps)
        else:
            self._stream.rate(**motion.rates)

    def _show(self, screen: LiveScreen, motion: SteeredMotion) -> None:
        now_s = time.monotonic()
        if now_s - self._shown_s >= SCREEN_S:
            self._shown_s = now_s
            screen.update(self.lines(self._client.call("status"), motion))

    def lines(self, status: dict[str, Any], motion: SteeredMotion) -> list[str]:
        """What is going on, what the keys do, where the arm is."""
        steering, run, joints = self._steering, status["run"], status["joints"]
        waits = run["countdown_s"] > 0.0
        state = f"MOTION CAN START IN {run['countdown_s']:.0f} s" if waits else "moving" if motion.moves else "standing still"
        keys = "← → ↑ ↓ tip" if steering.tip else keys_of(list(joints))
        others = "+ - speed   " + ("t joints/tip   " if steering.has_tip else "") + "e E-STOP   q end"
        return [
            coloured(f"run {run['run']}, filter {run['shaper']}: {state}", "yellow" if waits or motion.moves else "cyan"),
            f"{keys}   {others}",
            f"{100.0 * steering.speed:g} % of the limits: {', '.join(self._speeds(joints))}",
            *(f"{name:10} {self._shown(name, joint['position'], joint['unit'])}" for name, joint in joints.items()),
        ]

    def _speeds(self, joints: dict[str, Any]) -> list[str]:
        if self._steering.tip:
            return [f"tip {number(self._steering.tip_speed_mps)} m/s"]
        return [f"{name} {self._shown(name, rate, joints[name]['unit'])}/s" for name, rate in self._steering.rates.items()]

    def _shown(self, joint: str, value: float | None, si_unit: str) -> str:
        if value is None:
            return "not known"
        unit, factor, _ = self._units.get(joint, (si_unit, 1.0, 0.0))
        return f"{number(factor * value)} {unit}"
