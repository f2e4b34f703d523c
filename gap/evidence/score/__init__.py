"""How probable the logs are under one set of suspects: priors and coordinates of its numbers, its evidence, and shares of several sets.

Imports the noise and the deciding numbers; nothing of the search.
"""
