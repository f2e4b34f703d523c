"""What a rig file, a maneuver file and the plant in it may hold: pydantic models, SI inside, units as the user writes them.

Imports `errors` and `units`. Every room of config, and every folder that reads a rig, may import it.
"""
