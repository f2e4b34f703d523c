"""Supervisor, control process, I/O process, recorder: how each starts, what it asks of the system, how its end is noticed.

Imports every room before it.
"""
