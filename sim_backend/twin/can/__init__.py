"""Simulated CANopen nodes: object dictionary, SDO, PDO, heartbeat; CiA 406 encoder, CiA 408 valve, CiA 401 module; bus faults.

Imports `twin.faults`. `twin.assembly` puts them on a bus.
"""
