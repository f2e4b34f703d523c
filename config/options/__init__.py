"""What the devices of each shipped driver may be told (`devices: NAME: options:`), one model a driver.

Imports `schema` and `parsing`. Drivers, the daemon and the twin read their options here.
"""
