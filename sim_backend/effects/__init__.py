"""The physical effects that `plant.effects` of a rig file may name, one file each.

A file is all there is to an effect: its entry's parameters, the entries of the parameter vector it writes (or a law of its own), how it is
searched and how it shows. `config.schema.effect_library` finds the files because they are here (entry-point group `longreach.effects`).
They import `memory.layout` (where they write) and config, and nothing that takes long: every rig that is loaded loads them.
"""
