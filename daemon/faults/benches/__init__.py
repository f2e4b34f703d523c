"""What a fault is put into: the loop in lockstep, real processes, the hardware twin.

Imports `injections` and `fault`.
"""
