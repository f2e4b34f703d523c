"""Self-contained HTML pages beside a log: the run report, and the incident report of a fault.

They are made when a run is over, by the command line and never by the daemon, so they cost the loop nothing. Imports recording, tuning,
`checks`, `processes`, `server` and the loop in lockstep; `live` and the command line import it.
"""
