"""The control loop: read devices, check, step the controller, write outputs, record; commands from the supervisor.

Imports `cycle`, `checks`, `ipc` and `modes`.
"""
