"""`longreach live`: a Foxglove WebSocket, by Foxglove's own SDK, with the topics and messages of the log and its layout.

Imports `source`.
"""
