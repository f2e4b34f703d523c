"""What is left without a name: over which variable, and as a table in the rig file if the user wants to keep it.

Imports `outcome` and the rooms before it.
"""
