"""Commands about devices and their drivers: `longreach new-driver`, `longreach device`.

Imports drivers and config.
"""
