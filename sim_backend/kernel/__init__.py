"""The whole plant in compiled code: a rig's parameters as a vector, the rates of all states, integration, batches of windows.

Imports `memory` and `physics`; the effects come from `config.schema.effect_library`. `plant`, tuning and gap import it.
"""
