"""CANopen devices: the bus, a node's set-up, and the encoder (CiA 406), valve (CiA 408) and analogue module (CiA 401) on it.

Imports `contract` and `proof` of drivers.
"""
