"""Loading: the shipped files, files from disk, what the loader fills in, and YAML's traps."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from config.errors import ConfigError
from config.loading.load import find, load_maneuver, load_rig, maneuver_from_text, rig_from_text
from config.loading.shipped import shipped
from config.parsing.yaml_tree import parse
from config.schema.servo import LinearServo, RotaryServo
from tests.support.config.small_rig import SMALL, changed

INCH_M = 0.0254


@pytest.mark.parametrize("name", sorted(shipped("rigs")))
def test_every_shipped_rig_loads_by_name_and_by_path(name: str) -> None:
    by_name = load_rig(name)
    assert by_name.rig.name == name
    assert load_rig(by_name.path) == by_name
    assert by_name.text == Path(by_name.path).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", sorted(shipped("maneuvers")))
def test_every_shipped_maneuver_loads(name: str) -> None:
    assert load_maneuver(name).maneuver.name == name


def test_the_testbed_has_the_numbers_of_its_description() -> None:
    rig = load_rig("ornl_testbed").rig
    assert list(rig.joints) == ["rotary", "prismatic"]
    assert rig.joints["prismatic"].travel == pytest.approx((12 * INCH_M, 60 * INCH_M))
    rotary, prismatic = rig.servo["rotary"], rig.servo["prismatic"]
    assert isinstance(rotary, RotaryServo)
    assert isinstance(prismatic, LinearServo)
    gain_rad_per_s_per_V, gain_m_per_s_per_V = math.radians(43.09), 1.9 * INCH_M
    assert rotary.velocity_feedforward * gain_rad_per_s_per_V == pytest.approx(1, rel=1e-5)
    assert prismatic.velocity_feedforward * gain_m_per_s_per_V == pytest.approx(1, rel=1e-5)
    assert prismatic.gain * gain_m_per_s_per_V == pytest.approx(rotary.gain * gain_rad_per_s_per_V, rel=1e-3)  # same velocity constant
    tube_m = (1.0 * INCH_M, 0.6 * INCH_M)
    assert rig.link_mode is not None
    assert rig.link_mode.mass_per_length_kg_per_m == pytest.approx(7850 * math.pi / 4 * (tube_m[0] ** 2 - tube_m[1] ** 2), rel=1e-6)
    assert rig.link_mode.bending_stiffness_N_m2 == pytest.approx(200e9 * math.pi / 64 * (tube_m[0] ** 4 - tube_m[1] ** 4), rel=1e-6)


@pytest.mark.parametrize("y0_in", [12, 20, 24, 30, 36, 40, 50, 51.96])
def test_the_testbed_allows_the_line_of_the_paper_at_every_distance(y0_in: float) -> None:
    """Speeds and accelerations of the joints along x = ±30 in at 10 in/s, 100 in/s², differentiated numerically."""
    joints = load_rig("ornl_testbed").rig.joints
    y0, step_s = y0_in * INCH_M, 1e-4
    for x0_in in range(-30, 31):
        for speed, acceleration in ((0.254, 0.0), (0.254, 2.54), (-0.254, 2.54), (0.0, 2.54)):
            x = [x0_in * INCH_M + speed * t + acceleration * t * t / 2 for t in (-step_s, 0.0, step_s)]
            positions = {"rotary": [-math.atan2(value, y0) for value in x], "prismatic": [math.hypot(value, y0) for value in x]}
            for name, (before, now, after) in positions.items():
                joint = joints[name]
                assert joint.travel[0] - 1e-4 <= now <= joint.travel[1] + 1e-4
                assert abs(after - before) / (2 * step_s) < joint.rate_limit
                assert abs(after - 2 * now + before) / step_s**2 < joint.acceleration_limit


def test_motion_of_a_servo_follows_from_its_joint() -> None:
    rig = rig_from_text(SMALL)
    assert isinstance(rig.servo["axis"], LinearServo)
    assert rig.servo["axis"].gain == pytest.approx(8 / INCH_M)
    assert rig.signals["axis.position"].calibration.scale == pytest.approx(25e-6)
    assert rig.signals["axis.supply_pressure"].high == pytest.approx(3000 * 6894.757, rel=1e-6)


def test_bare_numbers_are_in_the_stored_unit_and_mean_the_same_as_written_units() -> None:
    assert rig_from_text(changed(("8 V/in", f"{8 / INCH_M!r}"))).servo == rig_from_text(SMALL).servo


def test_a_rig_survives_being_written_as_plain_data_and_read_again() -> None:
    rig = load_rig("ornl_testbed").rig
    assert type(rig).model_validate(rig.model_dump(by_alias=True)) == rig


def test_yaml_words_and_numbers_mean_what_they_look_like() -> None:
    tree = parse("a: off\nb: 12:30\nc: 1e5\nd: 010\ne: 2026-01-02\nf: ~\ng: true\nh: -.5\ni: 0x10\n", "x.yaml")
    assert tree.plain == {"a": "off", "b": "12:30", "c": 1e5, "d": 10, "e": "2026-01-02", "f": None, "g": True, "h": -0.5, "i": 16}
    assert isinstance(tree.plain["c"], float)


def test_unreadable_files(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"gone\.yaml: the file cannot be read: No such file or directory\. Check the path: `ls "):
        load_rig(tmp_path / "gone.yaml")
    with pytest.raises(ConfigError, match=r"the file cannot be read: Is a directory"):
        load_rig(f"{tmp_path}/")
    latin = tmp_path / "latin.yaml"
    latin.write_bytes("longreach: rig/1\nname: bänch\n".encode("latin-1"))
    with pytest.raises(ConfigError, match=r"latin\.yaml:2:8: the file is not UTF-8 text: byte 0xe4\. Save it as UTF-8\."):
        load_rig(latin)


def test_a_byte_order_mark_and_windows_line_ends_do_not_matter(tmp_path: Path) -> None:
    file = tmp_path / "bench.yaml"
    file.write_bytes(b"\xef\xbb\xbf" + SMALL.replace("\n", "\r\n").encode())
    assert load_rig(file).rig == rig_from_text(SMALL)


def test_an_unknown_shipped_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(ConfigError, match=r"'ornl_testbet' is not among the shipped rigs: nearest is 'ornl_testbed'"):
        find("rigs", "ornl_testbet")


@pytest.mark.parametrize(("kind", "name"), [("maneuvers", "my_line"), ("maneuvers", "my_jog"), ("rigs", "my_rig")])
def test_no_other_rig_or_motion_is_proposed_for_a_name_of_ones_own(
    kind: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConfigError) as refused:
        find(kind, name)
    assert "nearest" not in str(refused.value)
    Path(f"{name}.yaml").touch()
    with pytest.raises(ConfigError, match="A file of that name is here") as refused:
        find(kind, name)
    assert refused.value.refusal.mend == {name: f"{name}.yaml"}


def test_the_beginning_of_a_shipped_name_is_enough_to_propose_it() -> None:
    with pytest.raises(ConfigError, match="nearest is 'ornl_testbed'"):
        find("rigs", "ornl")


def test_the_same_text_again_is_the_same_rig() -> None:
    text = load_rig("ornl_testbed").text
    assert rig_from_text(text, "again.yaml") is rig_from_text(text, "again.yaml")


def test_a_maneuver_from_text() -> None:
    text = "longreach: maneuver/1\nname: line\nkind: straight_line\ny0: 30 in\nmoves: [30 in, -60 in, 30 in]\n"
    text += "speed: 10 in/s\nacceleration: 100 in/s^2\n"
    maneuver = maneuver_from_text(text)
    assert maneuver.model_dump()["moves_m"] == pytest.approx((0.762, -1.524, 0.762))
