"""longreach for programs: the stable surface. What is not here may change from one version to the next.

    import longreach

    log = longreach.load_log("run.mcap")                      # log.columns["rotary.position"]: numpy arrays, SI
    table = longreach.frame(log)                              # pandas
    log = longreach.simulate("ornl_testbed", "paper_line", shaper="adaptive", out="run.mcap")
    states = longreach.run_plant("ornl_testbed", commands_V, period_s=0.001)
    same = longreach.replay("run.mcap").identical
    with longreach.drive() as stream:                         # by hand: docs/guide/operate/drive-by-hand.md
        stream.rate(rotary=0.05)
    servo = longreach.design("ornl_testbed")                  # lines for `--set`
    found = longreach.find_gap("model.yaml", ["a.mcap"], ["b.mcap"], out="found")
    valid = [run for log in longreach.runs("logs") for run in log.runs if run.valid]
    print(longreach.compare("a.mcap", "b.mcap").text())
    pages = longreach.report("run.mcap")                      # HTML, beside the log

Ten lines on each stand in docs/guide/notebooks.

Rigs and maneuvers are files, or names of shipped ones. Every refusal is a `LongreachError` that says what, where and what to do.
Importing this imports nothing heavy; a function loads its libraries when it is called.
"""

from config.errors import LongreachError
from longreach.functions import compare, design, drive, find_gap, frame, load_log, load_rig, replay, report, run_plant, runs, simulate

__all__ = [
    "LongreachError", "compare", "design", "drive", "find_gap", "frame", "load_log", "load_rig", "replay", "report", "run_plant", "runs",
    "simulate",
]  # fmt: skip
