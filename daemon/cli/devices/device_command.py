"""`device`: find what is on a bus or line, read it, watch it; and the reference of an installed driver, plug-ins included."""

from __future__ import annotations

import argparse

from daemon.cli.devices import calibrate_verb, read_verb, scan_verb, watch_verb


def verbs(parser: argparse.ArgumentParser) -> None:
    verb = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    scan_verb.options(verb.add_parser("scan", help="find CANopen nodes and Modbus units; reads only"))
    read_verb.options(verb.add_parser("read", help="objects or registers once, raw and in engineering units"))
    watch_verb.options(verb.add_parser("watch", help="live values with min, max, mean and standard deviation"))
    calibrate_verb.options(verb.add_parser("calibrate", help="a sensor's sign, scale and zero from readings at known values"))
    options = verb.add_parser("options", help="options, channels and limits of a driver, as docs/reference/drivers.md")
    options.add_argument("driver", nargs="?", help="name of an installed driver; without it, the names of all")
    options.set_defaults(run_command=_options)


def _options(arguments: argparse.Namespace) -> int:
    from config.errors import ConfigError
    from config.options.driver_options import factories, options_schema
    from config.options.plug_ins import OPTIONS
    from config.parsing.nearest import nearest, nearest_text
    from config.reference import drivers_page

    known = sorted(factories())
    if arguments.driver is None:
        print("\n".join(known))
        return 0
    if arguments.driver not in known:
        what = f"there is no driver {arguments.driver!r}{nearest_text(arguments.driver, known)}"
        advice = f"Drivers: {', '.join(known)}. One of your own is known once its package is installed: pip install -e longreach-NAME."
        near = nearest(arguments.driver, known)
        raise ConfigError(what, next_step=advice, mend={arguments.driver: near} if near else {})
    schema = options_schema(arguments.driver)
    if schema is None:
        advice = f"Its package names them in the entry-point group {OPTIONS}: see `longreach new-driver`."
        raise ConfigError(f"the driver {arguments.driver!r} declares no options", next_step=advice)
    print(drivers_page({arguments.driver: schema}))
    return 0
