"""Equations formed from measurements alone (force, flow, link), and what makes them uneven.

Imports `data`.
"""
