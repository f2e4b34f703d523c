"""`service`: puts the installed longreach on this machine as a systemd service, and takes it away again.

What it does stands in daemon/systemd/install.sh, which the checkout's `make install` calls too. There is no service of a single user: it
could be given neither real-time priority nor locked memory. Without root, `longreachd RIG` runs in the foreground.
"""

from __future__ import annotations

import argparse
import sys

INSTALL = "program, units, user, directories, rules for adapters and CAN; repeating it replaces the program and keeps the rig file"
UNINSTALL = "what `install` put there; rig file, CAN files and logs stay"


def verbs(parser: argparse.ArgumentParser) -> None:
    under = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    install = under.add_parser("install", help=INSTALL, description=f"install longreach as a systemd service: {INSTALL}")
    install.add_argument("--python", metavar="FILE", default="/usr/bin/python3", help="what it runs with (default /usr/bin/python3)")
    uninstall = under.add_parser("uninstall", help=UNINSTALL, description=f"remove the service: {UNINSTALL}")
    for verb in (install, uninstall):
        verb.add_argument("--prefix", metavar="DIR", default="/opt/longreach", help="where the program lives (default /opt/longreach)")
        verb.add_argument("--destdir", metavar="DIR", default="", help="everything below DIR, without root: for a package")
    install.set_defaults(run_command=_install)
    uninstall.set_defaults(run_command=_uninstall)


def _install(arguments: argparse.Namespace) -> int:
    """The libraries come from the environment that this runs in, and of an installed wheel the program too."""
    return _script("install.sh", *_place(arguments), "--python", arguments.python, "--from-venv", sys.prefix)


def _uninstall(arguments: argparse.Namespace) -> int:
    return _script("uninstall.sh", *_place(arguments))


def _place(arguments: argparse.Namespace) -> tuple[str, ...]:
    return "--destdir", arguments.destdir, "--prefix", arguments.prefix


def _script(name: str, *options: str) -> int:
    import subprocess
    from importlib.resources import as_file, files

    with as_file(files("daemon.systemd")) as folder:
        return subprocess.run(["bash", str(folder / name), *options], check=False).returncode
