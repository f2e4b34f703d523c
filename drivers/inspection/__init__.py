"""Devices looked at without a rig's daemon: which nodes and units there are, what their objects and registers hold. Reads only.

Imports canopen and the Modbus client of drivers. `longreach device scan|read|watch` shows what is found.
"""
