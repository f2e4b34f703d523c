"""One effect, one file: files in a library of somebody else's are all it takes for schema, check, reference, kernel, search and tests.

The library is a package in a temporary folder with an entry point, as an installed one has it. Each of its effects brings its own law, one
at every hook of the kernel; nothing in the project knows them. They are looked at from processes of their own, because effects are found
when a process starts.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.support.sim_backend.effect_library import HOSE_SWELLING, OTHERS, Installed, installed, rig_text


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    files = {"hose_swelling": HOSE_SWELLING} | {name: other.file(name) for name, other in OTHERS.items()}
    return installed(tmp_path_factory.mktemp("library"), files)


LOOK = """
import json, sys
from config.loading.load import load_rig, rig_from_text
from config.reference import pages
from config.schema.effect_library import EFFECTS
rig = load_rig(sys.argv[1]).rig
seen = {"numba": "numba" in sys.modules, "value": rig.plant.effects[0].swelling, "last": list(EFFECTS)[-8:]}
seen["reference"] = pages()["plant.md"]
from gap.report.fingerprint import fingerprint_of
from gap.suspects.candidates import candidates
found = candidates(load_rig("ornl_testbed").rig, frozenset({"rotary.position"}))
found = [c for c in found if c.effect in list(EFFECTS)[-8:]]
seen["candidates"] = sorted(c.label for c in found)
(swelling,) = [c for c in found if c.label == "hose_swelling at rotary"]
seen["free"] = [(f.key, f.unit, f.start, f.scale, f.low, f.high) for f in swelling.free]
seen["equation"], seen["starts"] = swelling.equation, swelling.starts
seen["variable"] = fingerprint_of("hose_swelling", "rotary", ["rotary.position"], "", rig).variable
print(json.dumps(seen))
"""


def test_schema_reference_and_search_know_the_effect(library: Installed, tmp_path: Path) -> None:
    """Without numba: knowing effects must not make loading a rig slow."""
    rig = tmp_path / "rig.yaml"
    rig.write_text(rig_text("effect: hose_swelling, where: rotary, swelling: 2e-21 1/Pa^2/kPa"))
    seen = json.loads(library.run("-c", LOOK, str(rig)))
    assert not seen["numba"]
    assert seen["value"] == pytest.approx(2e-24)
    assert sorted(seen["last"]) == sorted(["hose_swelling", *OTHERS])  # after ours
    assert "`plant.effects[]` with `effect: hose_swelling`" in seen["reference"]
    assert "1/β_e = … + c P²" in seen["reference"]  # its law, from the file's docstring
    assert "| `swelling` | relative volume change of the hoses per pressure, per squared pressure | 1/Pa^3 |" in seen["reference"]
    at_joints = [name for name, other in OTHERS.items() if other.where in ("rotary", "prismatic")]
    assert seen["candidates"] == sorted(
        [f"{name} at {joint}" for name in ("hose_swelling", *at_joints) for joint in ("rotary", "prismatic")]
        + ["bent_sensor at sensor:rotary.position", "soft_supply at supply", "second_leaf at link"]
    )
    assert seen["free"] == [["swelling", "1/Pa^3", 0.0, pytest.approx(1.58e-24, rel=0.01), 0.0, pytest.approx(1.58e-22, rel=0.01)]]
    assert seen["equation"] == "chamber flow balance"
    assert seen["starts"] == [[pytest.approx(1.58e-24, rel=0.01)], [pytest.approx(6.31e-24, rel=0.01)]]
    assert seen["variable"] == "rotary.acceleration"


@pytest.mark.slow
def test_check_judges_its_entries(library: Installed, tmp_path: Path) -> None:
    rig = tmp_path / "rig.yaml"
    rig.write_text(rig_text("effect: hose_swelling, where: rotary, swelling: 2e-24"))
    library.run("-m", "daemon.cli.main", "check", str(rig))
    wrong = {
        "effect: hose_swelling, where: rotary, swelling: 2e-10": "swelling",
        "effect: hose_sweling, where: rotary, swelling: 2e-24": "hose_swelling",
        "effect: hose_swelling, where: link, swelling: 2e-24": "belongs at a joint",
    }
    for entry, word in wrong.items():
        rig.write_text(rig_text(entry))
        with pytest.raises(AssertionError, match=word):
            library.run("-m", "daemon.cli.main", "check", str(rig))


COMPLIANCE = """
from config.loading.load import load_rig
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.layout import J_START, J
from sim_backend.physics.chambers import compliance
import json, sys
import numpy as np
p, plain = Parameters(load_rig(sys.argv[1]).rig), Parameters(load_rig("ornl_testbed").rig)
j = J_START
softer = [compliance(P, 1.4e9, 1e-10, p.values, j) - compliance(P, 1.4e9, 1e-10, plain.values, j) for P in (0.0, 2e6, 8e6)]
print(json.dumps([softer, len(p.names) == p.values.size, bool(np.all(plain.values[436:] == 0))]))
"""


@pytest.mark.slow
def test_the_kernel_has_its_law_and_the_tests_have_its_case(library: Installed, tmp_path: Path) -> None:
    """The cases that the tests of effects make of the files: neutral is absent bit for bit, present is seen, and rates kept between periods
    are those computed anew, at every hook."""
    told = library.run(
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        "tests/sim_backend/effects/test_effects.py",
        "-k",
        " or ".join(["hose_swelling", *OTHERS]),
    )
    assert "24 passed" in told  # a case, kept rates and a look at the file each
    rig = tmp_path / "rig.yaml"
    rig.write_text(rig_text("effect: hose_swelling, where: rotary, swelling: 2e-24"))
    softer, named, rest_is_empty = json.loads(library.run("-c", COMPLIANCE, str(rig)))
    assert softer == pytest.approx([0.0, 2e-24 * 2e6**2, 2e-24 * 8e6**2], rel=1e-6)
    assert named
    assert rest_is_empty


BENDING = """
from config.loading.load import load_rig, rig_from_text
from gap.balance.balances import balances
from tests.gap.balance.test_weak_form import FLEXIBLE, SIGMA, log_of, swung
import json
effect = "    - {effect: second_leaf, where: link, size: 11.556}\\n"  # N/m: 3 (0.6 - 0.249) / 0.45³
rig = rig_from_text(load_rig("cu_flexible_arm").text.replace("  effects: []\\n", FLEXIBLE + effect))
print(json.dumps([balances(log_of(rig, swung(stiffness)), rig, SIGMA)[0].z for stiffness in (0.249, 0.6)]))
"""


@pytest.mark.slow
def test_the_balance_of_the_link_has_its_law(library: Installed) -> None:
    """A leaf spring beside the link: the tip swings as fast as a link of 0.6 N m² does, no longer as one of 0.249 N m²."""
    without_leaf, with_leaf = json.loads(library.run("-c", BENDING))
    assert without_leaf > 5
    assert with_leaf < 1.5


FIND = """
import json, sys
from pathlib import Path
from tests.support.gap import axis_logs
from config.loading.load import rig_from_text
from gap.find import find
folder = Path(sys.argv[1])
truth = rig_from_text(axis_logs.axis_text() + "    - {effect: return_spring, where: axis, size: 400}\\n")
logs = [axis_logs.write(folder / f"{name}.csv", axis_logs.simulated(truth, seed)) for seed, name in enumerate(("fit", "hold"), 11)]
model = folder / "axis.yaml"
model.write_text(axis_logs.axis_text())
find(model, logs[:1], logs[1:], folder / "out", lambda line: None)
"""


@pytest.mark.slow
def test_the_search_names_it(library: Installed, tmp_path: Path) -> None:
    """A spring of 400 N/m that no effect of ours can be: the search finds it from the logs alone, and writes a rig file that has it."""
    library.run("-c", FIND, str(tmp_path))
    content = json.loads((tmp_path / "out" / "findings.json").read_text())
    assert content["verdict"] == "named"
    (finding,) = content["findings"]
    assert (finding["effect"], finding["where"]) == ("return_spring", "axis")
    assert finding["parameters"]["size"]["value"] == pytest.approx(400, rel=0.05)
    assert "effect: return_spring" in (tmp_path / "out" / "rig.yaml").read_text()
