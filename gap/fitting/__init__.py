"""The model on windows of a log: simulation, start states, cost, sensitivities, least squares with priors.

Imports `data`.
"""
