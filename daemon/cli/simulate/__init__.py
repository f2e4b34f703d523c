"""`longreach simulate`: a maneuver on the simulated rig without a daemon, once or over a sweep of numbers.

Imports `daemon.lockstep`, recording and gap's executor.
"""
