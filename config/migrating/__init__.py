"""Rig files of earlier versions, rewritten for today's: one entry a change, line by line, so that comments and layout stay.

Imports `parsing`. `longreach check --migrate` uses it; nothing is migrated silently.
"""
