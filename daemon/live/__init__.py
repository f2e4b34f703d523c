"""What is watched while it happens. Each view is a process of its own that asks the daemon's socket; none of them is part of the daemon.

Imports `cycle`, `checks`, `server` and `reports`; the command line imports it. Rooms, each importing only from those before it:

- source: the one reader of live data: asks the socket, and hands every view the newest samples, status, checks and events
- page: `longreach ui`: the web page and its server
- terminal: `longreach top`: the same at a glance in a terminal
- foxglove: `longreach live`: a Foxglove WebSocket with the topics of the log
- playback: `longreach play`: a log behind a socket, for any of these
"""
