"""Σ, what a right model may still be off by: noise, slow discrepancy, unknown starts, friction of another form; and how large it is.

Imports `deciding_numbers` of the evidence, and what that may.
"""
