"""The 1997 paper as a regression test: its figures, tables and misprints, computed again (`longreach paper`).

Imports every room before it.
"""
