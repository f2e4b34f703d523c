"""Which effects are added: trials, acceptance, exchange, verdict.

Imports `data`, `fitting` and `signatures`.
"""
