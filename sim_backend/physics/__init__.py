"""One physical law a file, compiled: valve, chambers, supply, friction, link, heat, sensors, noise.

Imports `memory` and constants of `effects`. The kernel calls these; so do tests against closed forms.
"""
