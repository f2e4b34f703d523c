"""What the daemon's processes load before the arm can be held: each what it needs, and none what takes a second."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

FOR_RIGS = {"annotated_types", "pydantic", "pydantic_core", "typing_extensions", "typing_inspection", "yaml"}
FOR_LOGS = {"lz4", "mcap", "zstandard"}
# What the environment's own start loads (hooks of setuptools or of an editable install) is not the process's doing.
BEFORE = "import sys\nat_start = set(sys.modules)\n"
AFTER = """
import json
loaded = {name: getattr(module, "__file__", None) or "" for name, module in sys.modules.items() if name not in at_start}
print(json.dumps([name for name, file in loaded.items() if "site-packages" in file]))
"""


def loaded_after(code: str) -> set[str]:
    """Everything from site-packages that a new process loads, by its dotted name."""
    done = subprocess.run([sys.executable, "-c", BEFORE + code + AFTER], capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


def libraries(names: set[str]) -> set[str]:
    return {name.partition(".")[0] for name in names}


@pytest.mark.parametrize(
    ("process", "expected"),
    [("supervisor", FOR_RIGS), ("control_process", FOR_RIGS), ("io_process", FOR_RIGS), ("recorder_process", FOR_LOGS)],
)
def test_a_process_loads_only_its_libraries(process: str, expected: set[str]) -> None:
    assert libraries(loaded_after(f"import daemon.processes.{process}")) <= expected


def test_a_simulated_rig_loads_no_more_than_numpy_and_numba() -> None:
    code = "import drivers.registry\nfrom config.loading.load import load_rig\nrig = load_rig('ornl_testbed').rig\n"
    code += "name, device = next(iter(rig.devices.items()))\ndriver = drivers.registry.create(name, device, rig, True)\n"
    code += "driver.open(); driver.close()"
    loaded = loaded_after(code)
    assert {"numba", "numpy"} <= libraries(loaded)
    assert not {name for name in loaded if name.startswith(("scipy.linalg", "matplotlib", "pint", "numpy.testing", "numpy.f2py"))}
