"""Which frames of a device came in time, late or never. Found by counting: a frame does not say which SYNC it answers.

A device answers its SYNCs in order. While a frame is owed, each frame that comes counts as the one before it. A cycle with two frames
settles the debt: the frame that was owed has come late, and so have all that came meanwhile. When as many cycles had one frame as the
device may be silent for, the owed frame was lost, and those that came meanwhile were in time. So the verdict comes afterwards, and an
answer that becomes late for good, by whole cycles, looks like one lost frame.
"""

from __future__ import annotations


class FrameCount:
    """One `cycle()` each; nothing is owed before the first frame. `missing`: cycles since the last frame.

    `late`: frames that were used after the cycle in which they were due. `lost`: frames that never came.
    """

    def __init__(self, every_syncs: int, patience: int) -> None:
        """The device sends at every `every_syncs`-th SYNC. After `patience` frames without the one that is owed it is lost."""
        self._every_syncs, self._patience = every_syncs, patience
        self.late = self.lost = 0
        self.missing = every_syncs * patience
        self.restart()

    def restart(self) -> None:
        """The device begins anew: nothing is owed."""
        self._began = False
        self._owed = self._came_meanwhile = self._since_owed = 0

    def cycle(self, came: int) -> None:
        """One cycle, in which `came` frames were received."""
        self.missing += 1
        is_due = self.missing % self._every_syncs == 0
        if came:
            self.missing = 0
            self._came(came - is_due)
        elif is_due and self._began:
            self._owe()

    def _owe(self) -> None:
        """Never more than the device may be silent for: the oldest is then lost."""
        self._since_owed = 0
        if self._owed < self._patience:
            self._owed += 1
        else:
            self.lost += 1

    def _came(self, surplus: int) -> None:
        """`surplus`: frames more than were due."""
        self._began = True
        if not self._owed:
            return
        late = min(max(surplus, 0), self._owed)
        self._owed -= late
        self.late += late
        if not self._owed:
            self.late += self._came_meanwhile
            self._came_meanwhile = 0
            return
        self._came_meanwhile += 1
        self._since_owed += 1
        if self._since_owed >= self._patience:
            self.lost += self._owed
            self._owed = self._came_meanwhile = 0
