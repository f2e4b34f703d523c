"""Keeps the frames of a udp_multicast bus on this machine: python-can sends them wherever the default route leads."""

from __future__ import annotations

import ipaddress
import subprocess

from config.errors import ConfigError

EXAMPLE_GROUP = "239.74.163.2"


def refuse_leaking_multicast(group: str) -> None:
    """Returns when the kernel would send frames for `group` to the loopback device only.

    Raises ConfigError that names the way they would take.
    """
    try:
        is_multicast = ipaddress.IPv4Address(group).is_multicast
    except ValueError as error:
        advice = f"Use an IPv4 multicast group such as {EXAMPLE_GROUP}."
        raise ConfigError("the channel of udp_multicast is no IPv4 group", value=group, next_step=advice) from error
    way = _way_to(group)
    if not is_multicast or " dev lo " not in f"{way} ":
        advice = "Run in a network namespace: ip netns add N; ip -n N link set lo up multicast on; ip -n N route add 224.0.0.0/4 dev lo"
        raise ConfigError("udp_multicast frames would leave this machine", value=way, limit="dev lo", where=group, next_step=advice)


def _way_to(group: str) -> str:
    """What the kernel says about the route, in one line."""
    try:
        route = subprocess.run(["ip", "-4", "route", "get", group], capture_output=True, text=True, timeout=5, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"unknown: the command `ip` does not answer ({type(error).__name__})"
    return (route.stdout or route.stderr).split("\n")[0].strip()
