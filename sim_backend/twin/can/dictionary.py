"""Object dictionaries of the simulated devices: the shipped EDS files, which are also what the drivers expect a device to be."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import canopen
from canopen import objectdictionary as od

import config

NUMBER = {od.UNSIGNED8: "B", od.UNSIGNED16: "H", od.UNSIGNED32: "I", od.INTEGER8: "b", od.INTEGER16: "h", od.INTEGER32: "i"}
EDS = Path(config.__file__).parent / "eds"

RPDO, TPDO, MAPPING = 0x1400, 0x1800, 0x200  # first PDO's communication record each way; distance of its mapping record
PDOS = 4  # looked for in each direction
PDO_OFF = 1 << 31


@cache
def dictionary(profile: str, node: int) -> Any:
    """The object dictionary of `encoder_406`, `valve_408` or `io_401`, with COB-IDs for this node number. Values are kept elsewhere."""
    return canopen.import_od(str(EDS / f"{profile}.eds"), node)


def pdo_records(objects: Any) -> list[int]:
    """Communication records of the PDOs a device has: receive first, then transmit."""
    return [index for first in (RPDO, TPDO) for index in range(first, first + PDOS) if index in objects]
