"""The page of a driver before its table of options: who serves it, whether it proves its safe state, its channels and their limits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from config.options.device_options import Channel, DeviceOptions, RigNames
from config.options.driver_options import members

_EXAMPLE_RIG = RigNames(("JOINT",), ("SIGNAL",))
_SERVED = {
    "loop": "inside the loop",
    "I/O process": "by the I/O process: write `slow: true`",
    "either": "inside the loop, or by the I/O process with `slow: true`",
}


def about_driver(name: str, schema: Any) -> str:
    """Heading, service and channels of one driver; channels that follow from required options are left to the options' table."""
    options: type[DeviceOptions] = members(schema)[0]
    proof = " Can prove that the device goes safe by itself (`longreach prove`)." if options.proves_safe_state else ""
    rows = "".join(_channels(options))
    table = f"| channel | direction | meaning | unit | range |\n|---|---|---|---|---|\n{rows}" if rows else ""
    return f"\n# `driver: {name}`\n\nServed {_SERVED[options.served_by]}.{proof}\n" + (f"\n{table}" if table else "")


def _channels(options: type[DeviceOptions]) -> Iterator[str]:
    """One row a channel of a device whose options all have their defaults."""
    example = options.model_construct()
    try:
        found = {"input": example.input_channels(_EXAMPLE_RIG), "output": example.output_channels(_EXAMPLE_RIG)}
    except AttributeError:  # a required option names them
        return
    for direction, channels in found.items():
        for name, channel in channels.items():
            yield _row(name, direction, channel)


def _row(name: str, direction: str, channel: Channel) -> str:
    ends = f"{channel.low:.6g} to {channel.high:.6g}" if channel.low is not None and channel.high is not None else ""
    return f"| `{name}` | {direction} | {channel.about} | {channel.unit} | {ends} |\n"
