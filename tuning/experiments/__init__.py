"""Sine, release, line and excitation runs of the simulated arm, and what is measured of them.

Imports `linear`.
"""
