"""Measured data from other systems become a log: a table with units, its columns under the log's names, checks.

Imports `format` and `files`.
"""
