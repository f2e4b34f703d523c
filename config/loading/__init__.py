"""A file becomes a model that was checked against itself: load, overrides (--set), identified values, calibration records, import maps.

Imports `schema`, `parsing` and `options`. Whoever needs a rig or a maneuver imports it.
"""
