"""The Oak Ridge testbed with every kind of simulated device: two encoders, a valve, an analogue I/O module, a Modbus unit."""

from __future__ import annotations

import socket
from typing import Any

import yaml

from config.loading.load import load_rig, rig_from_text
from config.schema.rig import Rig

ROTARY_ENCODER, PRISMATIC_ENCODER, VALVE, IO = 3, 4, 5, 6
HEARTBEAT_REACTION_SUB, DEADLINE_REACTION_SUB = 36, 41
COUNTS_PER_VOLT = 3276.7

# Two words a temperature and floats in the other order, so that every type of the map is served.
CHANNELS: dict[str, dict[str, Any]] = {
    "rotary.supply_pressure": {"address": 0, "type": "uint16"},
    "rotary.return_pressure": {"address": 1, "type": "int16"},
    "prismatic.supply_pressure": {"address": 10, "type": "uint32", "word_order": "little"},
    "prismatic.return_pressure": {"address": 12, "type": "int32"},
    "rotary.supply_temperature": {"table": "holding", "address": 100, "type": "float32"},
    "rotary.return_temperature": {"table": "holding", "address": 102, "type": "float32", "word_order": "little"},
    "prismatic.supply_temperature": {"table": "holding", "address": 104, "type": "int16"},
    "prismatic.return_temperature": {"table": "holding", "address": 105, "type": "int16"},
    "reservoir_temperature": {"address": 14, "type": "int16"},
}
DROPPED = ("tip.deflection",)


class _NoAliases(yaml.SafeDumper):
    def ignore_aliases(self, data: Any) -> bool:
        return True


def twin_rig(channel: str, modbus_port: int, interface: str = "virtual") -> Rig:
    return rig_from_text(twin_rig_text(channel, modbus_port, interface), f"{channel}.yaml")


def twin_rig_text(channel: str, modbus_port: int, interface: str = "virtual") -> str:
    """The shipped rig file with its devices exchanged."""
    rig = yaml.safe_load(load_rig("ornl_testbed").text)
    rig["devices"] = _devices({"interface": interface, "channel": channel}, modbus_port)
    for name in DROPPED:
        del rig["signals"][name]
    rig.pop("end_point", None)  # it needs one of those
    for name, signal in rig["signals"].items():
        _connect(name, signal)
    rig["outputs"] = {
        "rotary": {"device": "rotary_valve", "channel": "spool", "scale": 0.1},  # 10 V open the valve fully
        "prismatic": {"device": "io", "channel": "output_1"},
    }
    return yaml.dump(rig, sort_keys=False, Dumper=_NoAliases)


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def _devices(bus: dict[str, Any], modbus_port: int) -> dict[str, Any]:
    reactions = {HEARTBEAT_REACTION_SUB: 2, DEADLINE_REACTION_SUB: 3}
    gauges = {"transport": "tcp", "host": "127.0.0.1", "port": modbus_port, "unit_id": 7, "channels": CHANNELS}
    return {
        "rotary_encoder": {"driver": "canopen_encoder_406", "options": {"bus": dict(bus), "node": ROTARY_ENCODER, "resolution": 72000}},
        "prismatic_encoder": {"driver": "canopen_encoder_406", "options": {"bus": dict(bus), "node": PRISMATIC_ENCODER}},
        "rotary_valve": {
            "driver": "canopen_valve_408",
            "timeout": "30 ms",
            "options": {"bus": dict(bus), "node": VALVE, "fault_reactions": reactions},
        },
        "io": {
            "driver": "canopen_io_401",
            "timeout": "30 ms",
            "options": {"bus": dict(bus), "node": IO, "outputs": 1, "inputs": 2, "loopback": {1: 2}},
        },
        "gauges": {"driver": "modbus", "slow": True, "options": gauges},
    }


def _connect(name: str, signal: dict[str, Any]) -> None:
    if name.endswith(".position"):
        joint = name.split(".")[0]
        low = {"rotary": "-90 deg", "prismatic": "0 m"}[joint]
        signal |= {"device": f"{joint}_encoder", "channel": "position"}
        signal["calibration"]["offset"] = low
    elif name == "tip.acceleration":
        signal |= {"device": "io", "channel": "input_1"}
    else:
        signal |= {"device": "gauges", "channel": name}
        signal["max_age"] = "2 s"
