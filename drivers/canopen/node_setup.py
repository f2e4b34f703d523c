"""Setting a CANopen node up before the loop: every object is written, read back and compared; a difference refuses the device.

The loop never comes here.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import canopen

from drivers.canopen.node_reader import NO_SUCH_OBJECT, NO_SUCH_SUB_INDEX, NodeReader

U8, U16, U32, I8, I16, I32 = "<B", "<H", "<I", "<b", "<h", "<i"
ON_SYNC, AT_ONCE = 1, 255  # transmission types: with every SYNC; by event, and for a receive PDO as soon as it arrives
_PDO_OFF = 1 << 31
_COB_ID_MASK = 0xBFFFFFFF  # bit 30 (no remote frames) is the device's own business
_PDOS = 4


@dataclass(frozen=True, slots=True)
class Setting:
    """What an object must hold. `mask`: the bits that are compared."""

    index: int
    sub: int
    value: int
    form: str
    what: str
    mask: int = 0xFFFFFFFF


def pdo_settings(
    receive: bool, number: int, node: int, transmission: int, mapping: Sequence[int], deadline_ms: int | None = None
) -> list[Setting]:
    """Parameters and mapping of the PDO `number` (1 to 4) at its predefined identifier, in the order CiA 301 asks for.

    `receive` as the node sees it. Mapped objects are index << 16 | sub-index << 8 | bits. `deadline_ms`: without a receive PDO
    for so long the node goes into its fault; None leaves the entry alone.
    """
    name = f"{'RPDO' if receive else 'TPDO'}{number}"
    parameters, maps = _pdo_indices(receive, number)
    cob_id = (0x200 if receive else 0x180) + 0x100 * (number - 1) + node
    settings = [
        Setting(parameters, 1, cob_id | _PDO_OFF, U32, f"{name} off while it is changed", _COB_ID_MASK),
        Setting(maps, 0, 0, U8, f"{name} mapping cleared"),
        *(Setting(maps, place, entry, U32, f"{name} mapped object {place}") for place, entry in enumerate(mapping, 1)),
        Setting(maps, 0, len(mapping), U8, f"{name} number of mapped objects"),
        Setting(parameters, 2, transmission, U8, f"{name} transmission type"),
    ]
    if deadline_ms is not None:
        settings.append(Setting(parameters, 5, deadline_ms, U16, f"{name} deadline in ms"))
    return [*settings, Setting(parameters, 1, cob_id, U32, f"{name} identifier", _COB_ID_MASK)]


class NodeSetup(NodeReader):
    """One node while it is set up: `with NodeSetup(bus, node, name) as setup: setup.write(...)`.

    Raises DriverError when the node does not answer, refuses an object, or does not keep what is written.
    """

    def write(self, settings: Sequence[Setting]) -> None:
        """Write and read back, one after the other."""
        for setting in settings:
            self._download(setting)
            self.compare(setting)

    def compare(self, setting: Setting) -> None:
        """Read, and refuse when it is not what is wanted."""
        found = self.read(setting.index, setting.sub, setting.form)
        if (found ^ setting.value) & setting.mask:
            raise self._error(
                f"{self._object(setting.index, setting.sub)} ({setting.what}) does not hold what it must",
                f"found {_number(found)}",
                f"wanted {_number(setting.value)}",
                "Is it the right device, and do its firmware and write protection allow this setting?",
            )

    def switch_off_other_pdos(self, used: Sequence[tuple[bool, int]]) -> None:
        """Every PDO the node has besides those `used` (receive, number) goes off: it would take time of the bus that is not budgeted."""
        for receive, number in ((receive, number) for receive in (False, True) for number in range(1, _PDOS + 1)):
            index = _pdo_indices(receive, number)[0]
            if (receive, number) not in used and self._has(index, 1):
                cob_id = self.read(index, 1, U32) | _PDO_OFF
                self.write([Setting(index, 1, cob_id, U32, "unused PDO off", _COB_ID_MASK)])

    def command(self, state: str, limit_s: float) -> None:
        """An NMT command, and the heartbeat that confirms it: "OPERATIONAL" or "PRE-OPERATIONAL"."""
        self._node.nmt.state = state
        end = time.monotonic() + limit_s
        found = "no heartbeat"
        while (left := end - time.monotonic()) > 0:
            try:
                found = self._node.nmt.wait_for_heartbeat(left)
            except canopen.nmt.NmtError:
                break
            if found == state:
                return
        raise self._error("did not follow an NMT command", found, state, "Check 0x1017 and that no other master is on the bus.")

    def pre_operational(self) -> None:
        """Process data stop; not confirmed, because heartbeats may not be set up yet."""
        self._node.nmt.state = "PRE-OPERATIONAL"

    def _download(self, setting: Setting) -> None:
        index, sub, data = setting.index, setting.sub, struct.pack(setting.form, setting.value)
        try:
            self._exchange(index, sub, lambda: self._node.sdo.download(index, sub, data))
        except canopen.SdoAbortedError as error:
            what = f"refused {_number(setting.value)} for {self._object(index, sub)} ({setting.what})"
            raise self._error(what, str(error)) from error

    def _has(self, index: int, sub: int) -> bool:
        try:
            self._exchange(index, sub, lambda: self._node.sdo.upload(index, sub))
        except canopen.SdoAbortedError as error:
            if error.code in (NO_SUCH_OBJECT, NO_SUCH_SUB_INDEX):
                return False
            raise self._error(f"refused to read {self._object(index, sub)}", str(error)) from error
        return True


def _pdo_indices(receive: bool, number: int) -> tuple[int, int]:
    """(communication parameters, mapping)"""
    parameters = (0x1400 if receive else 0x1800) + number - 1
    return parameters, parameters + 0x200


def _number(value: int) -> str:
    return f"{value} (0x{value & 0xFFFFFFFF:X})"


def supervision(own_node: int, timeout_s: float) -> Iterator[Setting]:
    """The node supervises our heartbeat: silent for `timeout_s`, and it takes its fault reaction.

    Off and on again, so that its watch begins with our next heartbeat: a node that knows us already must not miss us while it is set up.
    """
    yield Setting(0x1016, 1, 0, U32, "heartbeat consumer: off")
    yield Setting(0x1016, 1, own_node << 16 | round(1e3 * timeout_s), U32, "heartbeat consumer: our node << 16 | time in ms")
