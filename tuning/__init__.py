"""What is designed from a model or found from a run: frequency responses, limit cycles, compensators, shapers, payload, oil, the paper.

Imports sim_backend, recording, servo_control and config. Rooms, each importing only from those before it:

- linear: the arm about rest as a linear system, the closed loop, its margins, and the family of arms it must hold for
- new_rig: a rig file for one hydraulic axis, or an arm with a flexible link, from data sheets
- limit_cycles: describing functions and exact limit cycles
- experiments: runs on the simulated arm that are measured like runs of a real one
- responses: frequency responses from runs, and models fitted to them
- link_and_payload: the link's frequency and damping, and the payload, from free vibration
- loop_design: compensators that hold for a whole family of arms
- shaper_choice: what each command filter leaves on this rig, and which to take
- paper: the 1997 paper's figures and tables computed again
- oil: friction and flow over the oil's temperature
- sensor_calibration: a sensor's sign, scale and zero from readings at known values
- identification: `longreach identify`: everything a commissioning run tells, as a record

`transfer` is a transfer function, `variants` are the arms of the paper.
"""
