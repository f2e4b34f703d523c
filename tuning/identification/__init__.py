"""`longreach identify`: joint responses, link map, payload and oil table of one rig, as a record file with plots.

Imports every room of tuning.
"""
