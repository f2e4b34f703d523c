"""The checks themselves, each declared once; every file here has a tuple FAMILIES and is found by that. To add a check, touch one file.

Imports `daemon.checks.declaration` and what lies before it; nothing imports a file here by name but who needs its constants.
"""
