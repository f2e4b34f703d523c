"""Which move or sensor would tell explanations apart.

Imports `data`, `fitting`, `suspects` and `outcome`.
"""
