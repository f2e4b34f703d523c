"""Frequency and damping of the link and the mass at its tip, from how the tip moves in the holds.

Imports no other room of tuning.
"""
