"""Frequency responses from recorded runs, and the low-order models that fit them with bounds.

Imports `experiments`.
"""
