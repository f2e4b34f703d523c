"""A library of effects that cannot be used is left out, and whoever needs it hears why."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.support.sim_backend.effect_library import CHECKOUT, HOSE_SWELLING, Installed, installed, rig_text


def refused(folder: Path, files: Mapping[str, str]) -> str:
    """What a rig that names an effect of a library that cannot be used is told."""
    used = installed(folder, files)
    rig = folder / "rig.yaml"
    rig.write_text(rig_text("effect: hose_swelling, where: rotary, swelling: 2e-24"))
    program = "import sys\nfrom config.loading.load import load_rig\nload_rig('ornl_testbed')\nload_rig(sys.argv[1])\n"
    with pytest.raises(AssertionError) as caught:
        used.run("-c", program, str(rig))
    return str(caught.value)


@pytest.mark.slow
def test_a_library_that_cannot_be_used_is_left_out_and_says_why(tmp_path: Path) -> None:
    """Rigs that do not need it load; a rig that names one of its effects hears the reason."""
    assert "no_such_module" in refused(tmp_path / "import", {"hose_swelling": "import no_such_module\n"})
    assert "EFFECT = Effect(...)" in refused(tmp_path / "nothing", {"hose_swelling": "EFFECT = 3\n"})
    assert "there is a coulomb_friction already" in refused(
        tmp_path / "twice", {"coulomb_friction": HOSE_SWELLING.replace("hose_swelling", "coulomb_friction")}
    )
    foreign = installed(tmp_path / "warned", {"hose_swelling": "EFFECT = 3\n"})
    assert "warning" in (told := foreign.run("-m", "daemon.cli.main", "check", "ornl_testbed"))
    assert "the library of effects 'hoses' is left out" in told
    wide = HOSE_SWELLING.replace("pressure_Pa: float, swelling: float", "swelling: float")
    assert "takes (value, gauge_Pa, swelling)" in refused(tmp_path / "wide", {"hose_swelling": wide})
    for hook, place in (("SUPPLY", "'supply'"), ("BENDING", "'link'"), ("READING", "a sensor")):
        elsewhere = HOSE_SWELLING.replace("Hook.COMPLIANCE", f"Hook.{hook}")
        assert f"is at {place}" in refused(tmp_path / hook, {"hose_swelling": elsewhere})
    lost = HOSE_SWELLING.replace('("swelling",)', '("swelling", "width")')
    assert "law names 'width', which is no parameter" in refused(tmp_path / "lost", {"hose_swelling": lost})


@pytest.mark.slow
def test_a_law_that_cannot_be_compiled_is_named(tmp_path: Path) -> None:
    opening = HOSE_SWELLING.replace("return compliance + swelling * pressure_Pa**2", "return open('hose.csv').read()")
    with pytest.raises(AssertionError, match=r"the law of the effect hose_swelling cannot be compiled.*plain arithmetic"):
        installed(tmp_path, {"hose_swelling": opening}).run("-c", "import sim_backend.physics.chambers")


def test_metadata_older_than_the_library_of_effects_says_what_to_do(tmp_path: Path) -> None:
    """A checkout that was installed before the entry-point group was there."""
    metadata = tmp_path / "longreach-0.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: longreach\nVersion: 0.0\n")
    path = os.pathsep.join([str(tmp_path), str(CHECKOUT)])
    # Without PYTHONSAFEPATH the checkout comes first, with the metadata that an editable install may have left in it.
    old = Installed({**os.environ, "PYTHONPATH": path, "PYTHONSAFEPATH": "1"})
    with pytest.raises(AssertionError, match=r"longreach was installed before it had a library of effects; .*--editable \."):
        old.run("-m", "daemon.cli.main", "check", "ornl_testbed")
