"""The flexible link as the controller believes it: its mode, its motion, what the tip should deflect, and the feedback of what it does.

Imports `numerics`.
"""
