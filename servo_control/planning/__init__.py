"""A requested run becomes a plan: the motion, how long it takes, the vibration it predicts, and why it may not start.

Imports `path`, `shapers` and `link`.
"""
