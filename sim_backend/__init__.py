"""The simulated plant.

Imports config, and the kinematics of servo_control. Rooms, each importing only from those before it:

- memory: where each parameter, state and working number stands in the compiled code's arrays; how it is compiled and cached
- effects: the physical effects a rig file may name, one file each (`config.schema.effect_library` finds them)
- physics: one law a file: valve, chambers, supply, friction, link, heat, sensors
- kernel: parameters from a rig file, the rates of all states, integration, batches
- twin: the plant behind simulated CAN and Modbus devices, in a process of its own

`plant.SimulatedRig` is what a user of the room wants.
"""
