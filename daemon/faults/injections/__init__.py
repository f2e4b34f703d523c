"""How a fault is made: a clock that jumps, a full disk, a failing send, a device with wrong samples.

Imports drivers only.
"""
