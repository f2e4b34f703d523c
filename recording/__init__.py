"""The log: one MCAP file a recording, from the cycle's record to what a run was worth.

Imports config and servo_control. Rooms, each importing only from those before it:

- format: which fields a rig's log has, as a ROS 2 message; events
- files: writing, reading, recovery, what a file says of itself, export
- evaluation: tip vibration, spectra, plots, and the controller run again from a log
- importing: measured data from elsewhere (CSV) become such a log
"""
