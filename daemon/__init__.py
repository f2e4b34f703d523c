"""The processes on the rig and the command line that talks to them.

Imports every other folder; nothing imports it. Rooms, each importing only from those before it:

- cycle: what one cycle of the loop is made of: facts, timing, overruns, the clock, what it logs
- checks: what must hold before and while the arm moves, each with value, limit, unit and reaction
- ipc: memory shared between the processes, never waited on
- modes: disarmed, arming, proving, holding, running, stopping, fault: which follows which
- loop: the control loop itself: devices in, controller, devices out, record
- server: the socket's protocol and what each request does
- host: this computer: its facts, the real time it grants, which rates it keeps, and why no higher ones
- processes: supervisor, control, I/O and recorder process, and how they are started and watched
- systemd: the service: its units, and what puts them on a machine
- faults: the fault matrix: every fault put into a bench, and what the daemon did
- reports: pages made of a log when a run is over: what it did, what led to a fault
- live: views of what happens, each a process of its own: web page, terminal, Foxglove
- cli: `longreach`, one file a command

`lockstep` runs the same loop as fast as it goes, with the plant stepped inside.
"""

import sys

if sys.version_info < (3, 11):  # noqa: UP036  (in words that older ones can read, before anything they cannot)
    sys.exit(
        "longreach needs Python 3.11 or newer; this is %d.%d (%s). Next: make venv PYTHON=python3.11"  # noqa: UP031
        % (sys.version_info[0], sys.version_info[1], sys.executable)
    )
