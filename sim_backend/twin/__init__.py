"""The simulated plant behind simulated devices: real frames and registers, for tests of drivers and daemon without hardware.

Imports `plant` and every room below. The command line starts it (`longreach twin`). Rooms:

- can: nodes with an object dictionary: encoder, valve, analogue module
- modbus: a unit with registers and its server
"""
