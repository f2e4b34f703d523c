"""Lag-lead compensators for a whole family of arms: search, gain schedule, the stuck arm, pictures.

Imports `linear`, `limit_cycles` and `experiments`.
"""
