"""The one reader of live data: a connection to the socket, a feed that asks it in turn, and what each view has not taken yet.

Imports `daemon.server.protocol`; knows nothing of browsers and terminals.
"""
