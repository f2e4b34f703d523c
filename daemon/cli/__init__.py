"""`longreach`, the operator's command line: one file a command, joined by `command_line`; `main` is the console script.

Imports everything; nothing imports it. Rooms, each importing only from those before it:

- shown: tables, progress and numbers in a terminal, for all commands
- options: numbers, filters and files as several commands take them
- operate: check, status, why, arm, start, stop, prove, twin
- live: ui, top, live, play
- jog: drive by hand with a keyboard
- rigs: new-rig
- devices: new-driver, device
- simulate: a maneuver without a daemon, once or over a sweep
- demo: the paper's maneuver on a simulated rig
- logs: look at logs, import, export, repair, replay
- tune: identify, design, shape, warm-up, paper
- commission: the way to the first shaped move
- gap: find, next, loop, study, watch, demo
"""
