"""MCAP files: writer, reader, recovery of files cut short, description, checks, Foxglove layout, CSV export.

Imports `format`. The recorder, the command line and gap import it.
"""
