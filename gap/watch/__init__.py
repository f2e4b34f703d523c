"""Condition monitoring from the logs one has: the numbers that wear and faults change, log by log over weeks.

`watch` is the whole way. A log is fitted by itself (`log_fit`) and its numbers are kept (`kept_fits`), so that the next call fits what is
new; `watched` says which numbers are followed, `dated_logs` when each log was recorded. What the numbers do over the weeks is a straight
line and steps (`regression`, `course`); `followed` holds it against the limits. `page` and `plots` show it.

Imports every room of gap; the command line imports it.
"""
