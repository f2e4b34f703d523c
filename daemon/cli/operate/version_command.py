"""`version`: what is installed here, for a bug report and for scripts."""

from __future__ import annotations

import argparse
import json
import platform
from importlib.metadata import PackageNotFoundError, version

from daemon.cli.connection import add_json_option

LIBRARIES = ("numpy", "numba", "scipy", "control", "mcap", "pydantic", "python-can", "canopen", "pymodbus")  # whose version a report needs


def options(parser: argparse.ArgumentParser) -> None:
    add_json_option(parser)
    parser.set_defaults(run_command=_version)


def _version(arguments: argparse.Namespace) -> int:
    from daemon.host.host_facts import software

    facts = {**software(), "python": platform.python_version(), "system": f"{platform.system()} {platform.release()} {platform.machine()}"}
    libraries = {name: _installed(name) for name in LIBRARIES}
    if arguments.json:
        print(json.dumps({**facts, "libraries": libraries}))
        return 0
    print(f"longreach {facts['software_version']} (commit {facts['software_commit']}), Python {facts['python']}, {facts['system']}")
    print(", ".join(f"{name} {found}" for name, found in libraries.items()))
    return 0


def _installed(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
