"""A log as it is: its channels and their faults, noise, coarse steps, windows.

Imports recording and config; every room of gap may import it.
"""
