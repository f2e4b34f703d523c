"""The arm about rest as a linear system, its closed loop, stability margins, and the family of payloads, extensions and oils.

Imports `transfer`; every room of tuning may import it.
"""
