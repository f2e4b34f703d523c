"""Reading the objects of a CANopen node outside the loop. Nothing here writes one, and nothing commands a state.

This uses the `canopen` package, whose receiving thread runs only while a NodeReader is entered. The loop never comes here.
"""

from __future__ import annotations

import logging
import struct
from collections.abc import Callable
from types import TracebackType
from typing import Self, TypeVar

import can
import canopen

from config.errors import DriverError

NO_SUCH_OBJECT, NO_SUCH_SUB_INDEX = 0x06020000, 0x06090011  # SDO abort codes
_LISTEN_S = 0.02
T = TypeVar("T")

logging.getLogger("canopen").setLevel(logging.CRITICAL)  # it prints every time-out; these are told by DriverError


class NodeReader:
    """One node while it is asked: `with NodeReader(bus, node, name) as node: node.read(0x1000, 0, U32)`.

    Raises DriverError when the node does not answer or refuses an object.
    """

    def __init__(self, can_bus: can.BusABC, node: int, where: str) -> None:
        self._network = canopen.Network(can_bus)
        self._network.NOTIFIER_CYCLE = _LISTEN_S
        self._node = canopen.RemoteNode(node, canopen.ObjectDictionary())
        self._number = node
        self._where = where

    def __enter__(self) -> Self:
        self._network.connect()
        self._network.add_node(self._node)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        del self._network[self._number]
        self._network.notifier.stop()

    def upload(self, index: int, sub: int) -> bytes:
        """The bytes of an object of any length."""
        try:
            return self._exchange(index, sub, lambda: bytes(self._node.sdo.upload(index, sub)))
        except canopen.SdoAbortedError as error:
            raise self._error(f"refused to read {self._object(index, sub)}", str(error)) from error

    def read(self, index: int, sub: int, form: str) -> int:
        """The value of an object of this form."""
        data = self.upload(index, sub)
        size = struct.calcsize(form)
        if len(data) < size:
            raise self._error(f"{self._object(index, sub)} has the wrong size", f"{len(data)} bytes", f"{size} bytes")
        return int(struct.unpack(form, data[:size])[0])

    def _exchange(self, index: int, sub: int, transfer: Callable[[], T]) -> T:
        """What the transfer gives. Raises SdoAbortedError when the node refuses, DriverError when it is silent or talks nonsense."""
        try:
            return transfer()
        except canopen.SdoAbortedError:
            raise
        except canopen.SdoCommunicationError as error:
            raise self._silent(index, sub) from error
        except Exception as error:  # the package unpacks whatever stands in an answer
            what = f"the answer about {self._object(index, sub)} cannot be read"
            raise self._error(what, f"{type(error).__name__}: {error}", next_step="Is another master talking to the node?") from error

    def _object(self, index: int, sub: int) -> str:
        return f"object 0x{index:04X} sub-index {sub}"

    def _silent(self, index: int, sub: int) -> DriverError:
        return self._error(
            f"did not answer about {self._object(index, sub)}",
            next_step="Check its supply, cable, node number and bit rate, and terminators.",
        )

    def _error(self, what: str, value: str = "", limit: str = "", next_step: str = "") -> DriverError:
        return DriverError(f"node {self._number}: {what}", value=value, limit=limit, where=self._where, next_step=next_step)
