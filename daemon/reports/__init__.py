"""Self-contained HTML pages beside a log: the run report, and the incident report of a fault.

They are made when a run is over, by the command line and never by the daemon, so they cost the loop nothing. Imports recording, tuning and
the loop in lockstep; the command line imports it.
"""
