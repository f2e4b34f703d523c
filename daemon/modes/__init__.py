"""The mode machine, who keeps it, and what happens to a run.

Imports `cycle` and `checks`.
"""
