"""Limit cycles of friction, dead band and backlash: describing functions (predicted) and exact periodic solutions.

Imports `linear`.
"""
