"""What can be known of a rig with no hardware: bus load, plant, calibrations, supply. `longreach check` prints what it finds.

Imports every room of config. The command line imports it.
"""
