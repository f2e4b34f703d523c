"""Whether the daemon itself is fit to move the arm: e-stop latch, timing of the loop, recorder, disk, supervisor."""

from __future__ import annotations

from math import inf

from daemon.checks.checks import Reaction
from daemon.checks.declaration import Declaration, Family, Purpose, Stage, the_daemon
from daemon.cycle.log_stream import RECORDER_RING_S

RECORDER_AGE_LIMIT_S = 0.5 * RECORDER_RING_S  # it reports after each sync: a disk that keeps it waiting so long loses no row yet
SUPERVISOR_AGE_LIMIT_S = 2.0
_LATE = "Look for other work on this computer; `longreach status` names the slowest phase. Then `longreach reset`, or lower loop.rate."
_LOST = "`longreach events` says why, a full disk for one; then `longreach reset` starts the recorder again: no run goes without a log."
_ALSO_PROOF = (Purpose.ARMED, Purpose.PROOF)

E_STOP = Declaration(
    name="e-stop",
    fact="estop_latched",
    meaning="1 from the start of the daemon and from every `longreach estop` until a reset",
    unit="",
    limits=lambda rig, subject: (0, 0),
    limit_from="0: released",
    source="daemon",
    reaction=Reaction.FAULT,
    advice="Make sure the arm may move, then `longreach reset`.",
    purposes=_ALSO_PROOF,
)
STALL = Declaration(
    name="loop stall",
    fact="loop.late_s",
    meaning="how long after the next deadline the last cycle ended",
    unit="s",
    limits=lambda rig, subject: (-inf, rig.loop.overruns.fault_late_s),
    limit_from="at most `loop.overruns.fault_late`",
    source="loop",
    reaction=Reaction.FAULT,
    advice=_LATE,
)
TIMING = Declaration(
    name="loop timing",
    fact="loop.overruns_in_window",
    meaning="cycles within `loop.overruns.window` that ended after the next deadline",
    unit="overruns",
    limits=lambda rig, subject: (0, rig.loop.overruns.stop_after - 1),
    limit_from="fewer than `loop.overruns.stop_after`",
    source="loop",
    reaction=Reaction.STOP,
    advice=_LATE,
)
RECORDER_LOST = Declaration(
    name="recorder lost",
    fact="recorder.failed",
    meaning="1 when the recorder process has ended or cannot write",
    unit="",
    limits=lambda rig, subject: (0, 0),
    limit_from="0: it writes",
    source="recorder",
    reaction=Reaction.STOP_THEN_FAULT,
    advice=_LOST,
    purposes=_ALSO_PROOF,
)
RECORDER_SILENT = Declaration(
    name="recorder silent",
    fact="recorder.age_s",
    meaning="time since the recorder last reported; a slow disk keeps it waiting",
    unit="s",
    limits=lambda rig, subject: (-inf, RECORDER_AGE_LIMIT_S),
    limit_from=f"at most {RECORDER_AGE_LIMIT_S:g} s, half of what the ring to it holds",
    source="recorder",
    reaction=Reaction.STOP_THEN_FAULT,
    advice=_LOST,
)
DROPS = Declaration(
    name="records dropped",
    fact="recorder.drops",
    meaning="records of this recording that did not reach the recorder",
    unit="records",
    limits=lambda rig, subject: (0, 0),
    limit_from="none",
    source="recorder",
    reaction=Reaction.STOP_THEN_FAULT,
    advice="Use a faster disk or a lower loop.rate, then `longreach reset`.",
)
DISK = Declaration(
    name="disk space",
    fact="disk.free_bytes",
    meaning="free space where logs are written",
    unit="bytes",
    limits=lambda rig, subject: (rig.interlocks.disk_free_min_bytes, inf),
    limit_from="at least `interlocks.disk_free_min`",
    source="log directory",
    reaction=Reaction.STOP,
    advice="Move old logs away (`df -h` shows the room), then `longreach why`.",
)
SUPERVISOR = Declaration(
    name="supervisor alive",
    fact="supervisor.age_s",
    meaning="time since the supervisor last reported",
    unit="s",
    limits=lambda rig, subject: (-inf, SUPERVISOR_AGE_LIMIT_S),
    limit_from=f"at most {SUPERVISOR_AGE_LIMIT_S:g} s",
    source="supervisor",
    reaction=Reaction.STOP,
    advice="See `systemctl status longreachd`; restart the daemon.",
)

HOST_RATE = Declaration(
    name="host keeps the rate",
    fact="host.rate_Hz",
    meaning="the highest rate up to which `longreach host` saw this computer, as it is now, keep every rate; 0: nothing that counts",
    unit="Hz",
    limits=lambda rig, subject: (rig.loop.rate_Hz, inf) if rig.loop.demand_rate else None,
    limit_from="at least `loop.rate` where `loop.demand_rate` is true",
    source="longreach host",
    reaction=Reaction.REFUSE,
    advice="End the daemon, run `longreach host --load --rig RIG` (for the service as root); `longreach why --all` shows what counts.",
)

_CHECKS = (E_STOP, STALL, TIMING, RECORDER_LOST, RECORDER_SILENT, DROPS, DISK, SUPERVISOR, HOST_RATE)
FAMILIES = (Family("The daemon", Stage.DAEMON, the_daemon, _CHECKS),)
