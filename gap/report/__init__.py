"""The report as one HTML page, and its pictures.

Imports every room of gap.
"""
