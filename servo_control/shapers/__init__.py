"""Command filters: three-term, ZV, notch, phase-adaptive, zero-delay; how one is chosen and set up.

Imports `numerics`, `link` and `path`.
"""
