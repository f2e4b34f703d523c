"""Driving by hand: set points that arrive while the arm moves become targets within the joints' limits, shaped as they come.

Imports `numerics`, `link`, `path`, `shapers` and `planning`.
"""
