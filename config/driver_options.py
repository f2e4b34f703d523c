"""Which schema the `options:` of a device follow, by the name of its driver."""

from __future__ import annotations

from typing import Any

from config.canopen_options import OPTIONS
from config.modbus_options import AnyModbusOptions


def options_schema(driver: str) -> Any | None:
    """A Section or a union of Sections; None for a driver whose options are known to itself alone (plug-ins)."""
    return AnyModbusOptions if driver == "modbus" else OPTIONS.get(driver)
