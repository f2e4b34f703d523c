"""What each command filter leaves of the tip's vibration on this rig, with wrong frequency and payload, and which one to take.

Imports `experiments` and `link_and_payload`.
"""
