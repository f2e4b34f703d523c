"""Which move or sensor would tell explanations apart.

Imports `data`, `fitting`, `signatures` and `search`.
"""
