"""This computer as a place for the loop: its facts, the real time it grants, which rates a log says it kept, and what makes it late.

Imports none of the other rooms. `longreach host` measures and keeps what it found; the daemon reads that, the demo measures for itself.
"""
