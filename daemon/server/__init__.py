"""The Unix socket: protocol, connections, requests and what each does, status, history of events.

Imports `cycle`, `checks`, `modes` and `loop.command`. The command line imports `protocol`.
"""
