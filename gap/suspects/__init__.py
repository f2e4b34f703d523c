"""The effects that may be missing on a rig, where each is first tried, and what is large at its place.

Imports `data` and `fitting`.
"""
