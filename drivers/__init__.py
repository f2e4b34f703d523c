"""Devices: the contract of a driver, the registry of those installed, and the drivers that come with longreach.

Imports config; `sim` imports sim_backend. The daemon asks `registry` for a device's driver and never imports one by name. Rooms:

- canopen: CiA 406 encoder, CiA 408 valve, CiA 401 analogue module on one bus
- inspection: what is on a bus or line, and what it says, without a daemon; reads only
"""
