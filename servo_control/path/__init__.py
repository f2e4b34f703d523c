"""Where the arm shall be when, before shaping: trajectories, waves, lines, pieces and programs of them, within the joints' limits.

Imports `link` (kinematics).
"""
