"""`longreach commission`: the way from a rig file to the first shaped move, step by step, each with a record.

Imports what the verbs that it walks through are made of: runs of the loop, identification, design, gap search. Files in their order:
`bench` is the rig or its simulation, `record` what a step leaves, `at_rest`, `moving` and `tuned` are the steps, `steps` their list.
"""
