"""The Oak Ridge rig with a slow loop: tests of what is watched need a daemon that keeps up beside a browser on a busy machine."""

from __future__ import annotations

from pathlib import Path

from config.loading.load import apply_overrides, load_rig

_CHANGES = ("loop.rate=250 Hz", "loop.overruns.fault_late=1 s", "loop.overruns.stop_after=1000", "loop.set_point_timeout=0.5 s")


def gentle_rig(directory: Path) -> str:
    path = directory / "gentle.yaml"
    path.write_text(apply_overrides(load_rig("ornl_testbed").text, list(_CHANGES)))
    return str(path)
