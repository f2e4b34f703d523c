"""Which options of the device verbs say something where: one that says nothing there is refused, never passed over."""

from __future__ import annotations

import argparse

from config.errors import UsageError

RIG_CAN, RIG_MODBUS, RIG, CAN, TCP, RTU = "a CANopen device of a rig", "a Modbus device of a rig", "a rig file", "a CAN bus", "tcp", "rtu"

_RIG = frozenset({RIG, RIG_CAN, RIG_MODBUS})
_CAN = frozenset({CAN})
_RTU = frozenset({RTU})
_MODBUS = frozenset({TCP, RTU})
_MEANT_FOR = {
    "device": _RIG,
    "bitrate": _CAN,
    "node": _CAN,
    "object": frozenset({CAN, RIG, RIG_CAN}),
    "eds": frozenset({CAN, RIG, RIG_CAN}),
    "baud_rate": _RTU,
    "parity": _RTU,
    "stop_bits": _RTU,
    "answer_timeout": _MODBUS,
    "unit": _MODBUS,
    "table": _MODBUS,
    "address": _MODBUS,
    "count": _MODBUS,
    "type": _MODBUS,
    "word_order": _MODBUS,
}


def refuse_others(arguments: argparse.Namespace, place: str) -> None:
    """UsageError for the first option given that says nothing at this place: a read with it would not be what was asked for."""
    for name, places in _MEANT_FOR.items():
        given = getattr(arguments, name, None)
        if given not in (None, []) and place not in places:
            raise UsageError(
                f"{_word(name)} says nothing for {_said(place)}", value=_text(given), where=arguments.where, next_step=_advice(place)
            )


def _word(name: str) -> str:
    return "DEVICE" if name == "device" else "--" + name.replace("_", "-")


def _text(given: object) -> str:
    return " ".join(map(str, given)) if isinstance(given, list) else str(given)


def _said(place: str) -> str:
    return {TCP: "a Modbus host", RTU: "a serial line"}.get(place, place)


def _advice(place: str) -> str:
    if place in _RIG:
        return "The rig file says it: leave it out, or name the bus or line instead (socketcan:can0, tcp:HOST, rtu:PORT)."
    return "Leave it out."
