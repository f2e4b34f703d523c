"""Reading one small object of a node while the loop goes on: one request, one answer, one step a cycle.

Set-up reads with the canopen package (node_setup); that listens in a thread of its own, which must not take the loop's frames.
"""

from __future__ import annotations

import struct
import time

import can

from config.errors import DriverError
from drivers.canopen.bus import CanopenBus, Steps

REQUEST_ID, ANSWER_ID = 0x600, 0x580
_REQUEST = struct.Struct("<BHB4x")
_UPLOAD, _ABORT = 0x40, 0x80
_EXPEDITED = 0b010_0_00_1_1  # answer with up to four bytes, their number given


def upload(bus: CanopenBus, node: int, index: int, sub: int, limit_s: float) -> Steps[bytes]:
    """The one to four bytes of an object. DriverError when the node does not answer in time, or not with such bytes."""
    where = f"node {node}: object 0x{index:04X} sub-index {sub}"
    request = upload_request(node, index, sub)
    answers: list[bytes] = []
    bus.route(ANSWER_ID + node, lambda data, stamp_ns: answers.append(bytes(data)))
    try:
        bus.send(request)
        end = time.monotonic_ns() + round(1e9 * limit_s)
        while not answers:
            if time.monotonic_ns() > end:
                raise DriverError(f"{where} was not answered", limit=limit_s, unit="s", where=bus.settings.channel)
            yield
    finally:
        bus.unroute(ANSWER_ID + node)
    return _content(answers[0], bytes(request.data), where)


def upload_request(node: int, index: int, sub: int) -> can.Message:
    """What a node answers with the content of an object."""
    return can.Message(arbitration_id=REQUEST_ID + node, is_extended_id=False, data=_REQUEST.pack(_UPLOAD, index, sub))


def _content(answer: bytes, request: bytes, where: str) -> bytes:
    if len(answer) == 8 and answer[1:4] == request[1:4]:
        if answer[0] & 0b111_1_00_1_1 == _EXPEDITED:
            return answer[4 : 8 - (answer[0] >> 2 & 0b11)]
        if answer[0] == _ABORT:
            raise DriverError(f"{where} was refused", value=f"0x{int.from_bytes(answer[4:], 'little'):08X}")
    raise DriverError(f"{where}: the answer cannot be read", value=answer.hex(" "))
