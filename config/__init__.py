"""Rig files, maneuver files and everything else a user writes: what may stand in them, how they are read, what is wrong with them.

Imports nothing of the project; every other folder may import it. Rooms, each importing only from those before it:

- schema: what a rig file and a maneuver file may hold, as pydantic models with units
- parsing: YAML with line numbers, and errors that name file, line and nearest right word
- options: what each shipped driver's device may be told
- loading: a file becomes a checked model: overrides, identified values, calibrations, shipped files
- migrating: keys of older files in the words of today, comments and layout kept
- checking: what `longreach check` looks at beyond the schema

`errors` is the one exception tree, `units` the one place that converts; `reference` writes docs/reference from all of it.
"""
