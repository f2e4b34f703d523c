"""What one cycle is made of: the facts that checks and log share, timing, overruns, the clock, what goes into the log.

Imports recording, drivers and config. Every room of the daemon may import it.
"""
