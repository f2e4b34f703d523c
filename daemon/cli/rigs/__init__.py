"""Commands about rig files of one's own: `longreach new-rig`.

Imports tuning and config.
"""
