"""What a reader is told about an unnamed remainder that was to be kept; light to import, for the command line."""

from __future__ import annotations

from typing import Any


def kept_sentence(rest: dict[str, Any]) -> str:
    """For a reader: whether the rig file has it now."""
    kept = rest["kept"]
    if kept is None:
        return "None of it is in the improved rig file."
    if not kept["kept"]:
        return f"None of it is in the improved rig file: {kept['why']}."
    over = kept["variable"]
    span = f"{over['name']} from {over['at'][0]:.4g} to {over['at'][-1]:.4g} {over['unit']}"
    fall = f"the hold-out falls from {kept['holdout_before']:.4g} to {kept['holdout_after']:.4g} noise floors"
    warned = " It pushes along with the motion at some velocity." if kept["drives"] else ""
    entry = f"unnamed_remainder at {kept['where']}, a table of {'friction' if 'friction' in kept else 'force'} over {span} and no physics"
    return f"Part of it is in the improved rig file as {entry}: {fall}.{warned}"
