"""The arrays of the compiled code: which column holds what (`layout`), working memory, compile options and cache.

Imports config only; every room of sim_backend may import it.
"""
