"""`longreach top`: what the page shows, at a glance in a terminal, also over SSH.

Imports `source`. `glance` turns what was received into lines, `screen` keeps them on the terminal.
"""
