"""`longreach play`: a log behind a socket of its own that answers like the daemon's, so that every view shows it. Nothing can be driven.

Imports nothing of `source` and the views: they ask it as they ask a daemon.
"""
