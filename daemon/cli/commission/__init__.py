"""`longreach commission`: the way from a rig file to the first shaped move, step by step, each with a record.

Imports what the verbs that it walks through are made of: runs of the loop, identification, design, gap search. Files in their order:
`bench` is the rig or its simulation, `record` what a step leaves; the steps are in `at_rest`, `moving`, `identified` and `tuned`, their
list in `steps`.
"""
