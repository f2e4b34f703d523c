"""This computer as a place for the loop: its facts, the real time it grants, how late it wakes up at which rate, and why.

Imports cycle. `longreach host` measures and keeps what it found; the daemon reads that, the demo measures for itself.
"""
