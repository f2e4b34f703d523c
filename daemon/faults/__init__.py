"""The fault matrix (`longreach faults`): every fault is put into a bench, and what the daemon did is compared with what it must do.

Imports the rooms before it. Rooms:

- injections: how a fault is made: a clock that jumps, a disk that is full, a device with wrong samples
- benches: what it is put into: lockstep, real processes, the hardware twin
"""
