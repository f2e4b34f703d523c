"""A rig file from data sheets: one hydraulic axis, or an arm of two with a flexible link between hub and payload; servos designed
from their own numbers, and maneuvers that suit them.

Imports linear and config. `longreach new-rig` asks for the numbers and writes the files.
"""
