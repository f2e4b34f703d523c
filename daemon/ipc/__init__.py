"""Memory shared between the processes: a ring of records, mailboxes of latest values. Nobody waits on another.

Imports `cycle`.
"""
