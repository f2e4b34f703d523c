"""Pure mathematics of the arm's control: no I/O, no clock, no threads, no randomness.

`controller.Controller.step(inputs) -> outputs` is all of it once a cycle; `signals` are its inputs and outputs. Imports only config; the
folder is not called `control` because python-control is. Rooms, each importing only from those before it:

- numerics: a table, normal equations, limits
- link: the flexible link: frequency, motion, expected deflection, estimator, end-point feedback
- path: trajectories and what moves are made of
- shapers: command filters that leave no vibration
- planning: a maneuver becomes a run: motion, duration, prediction, what speaks against it
- streaming: driving by hand: set points that arrive become targets within the limits, shaped as they come
- servo: the joint's loop: lag-lead, velocity, oil compensation, the link's notch
"""
