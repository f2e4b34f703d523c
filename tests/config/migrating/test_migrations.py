"""Older rig files in today's words: every file the repository ever shipped, and the old ways of writing each key, block or flow style."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
import yaml

from config.errors import ConfigError
from config.loading.load import find, rig_from_text
from config.loading.shipped import shipped
from config.migrating.migrate_file import BOM, migrate_file
from config.migrating.migrations import MIGRATIONS, migrated
from daemon.cli.main import main

CHECKOUT = Path(__file__).parents[3]
OLD = Path(__file__).parent / "old_rigs" / "friction_gain_in_volts.yaml"  # config/rigs/ornl_testbed.yaml of deeb7c1
TESTBED = find("rigs", "ornl_testbed").read_text()
CAN = find("rigs", "ornl_testbed_can").read_text()


def changed_lines(before: str, after: str) -> list[tuple[str, str]]:
    return [(old, new) for old, new in zip(before.splitlines(), after.splitlines(), strict=True) if old != new]


def history() -> list[tuple[str, str]]:
    """(commit and path, text) of every rig file in git; empty where there is no repository."""
    listing = subprocess.run(
        ["git", "log", "--reverse", "--format=%h", "--raw", "--no-abbrev", "--", "config/rigs/*.yaml"],
        cwd=CHECKOUT, capture_output=True, text=True, check=False,
    ).stdout  # fmt: skip
    found: dict[str, tuple[str, str]] = {}
    commit = ""
    for line in listing.splitlines():
        if not line.startswith(":"):
            commit = line or commit
            continue
        blob, path = line.split()[3], line.split("\t")[-1]
        if set(blob) != {"0"} and blob not in found:
            text = subprocess.run(["git", "cat-file", "blob", blob], cwd=CHECKOUT, capture_output=True, text=True, check=True).stdout
            found[blob] = (f"{commit} {path}", text)
    return list(found.values())


def test_every_rig_file_ever_shipped_loads_after_its_migrations() -> None:
    files = history()
    if len(files) < 20:
        pytest.skip("the repository's history is not here")
    for name, text in files:
        rig_from_text(migrated(text)[0], name)


def test_todays_files_have_nothing_to_migrate() -> None:
    for name in shipped("rigs"):
        text = find("rigs", name).read_text()
        assert migrated(text) == (text, []), name


def test_an_old_friction_gain_becomes_a_share_of_the_friction() -> None:
    """Decision 9: volts = friction(T) · share; 0.0232072 V·s/deg over the table's largest friction, 35.9 mV at 60 °C."""
    before = OLD.read_text()
    with pytest.raises(ConfigError, match=r"friction_gain: wrong kind of unit"):
        rig_from_text(before)
    after, done = migrated(before)
    assert [each.path for each in done] == ["end_point.friction_gain"]
    ((old, new),) = changed_lines(before, after)
    assert done[0].line == before.splitlines().index(old) + 1
    rig = rig_from_text(after)
    assert rig.end_point is not None
    oil = rig.servo["rotary"].oil_compensation
    assert oil is not None
    largest_V = max(point.friction_V for point in oil.points)
    assert rig.end_point.friction_gain == pytest.approx(0.0232072 * 180 / 3.14159265 / largest_V, rel=1e-3)
    assert old.split("#")[1] in new
    assert "was 0.0232072 V*s/deg" in new


def test_a_friction_gain_without_an_oil_table_becomes_a_comment() -> None:
    text = "longreach: rig/1\nend_point:\n  gain: 0.5\n  friction_gain: 1 V*s/rad  # mine\n"
    after, _ = migrated(text)
    assert yaml.safe_load(after)["end_point"] == {"gain": 0.5}
    assert "# friction_gain: 1 V*s/rad  # mine" in after


@pytest.mark.parametrize(
    ("text", "wanted", "kept"),
    [
        ("end_point:\n  gain: 1\n  frequency_ratio: 0.8   # [D] by trying\n", {"gain": 1}, "# frequency_ratio: 0.8   # [D] by trying"),
        ("end_point: {gain: 1, frequency_ratio: 0.8}\n", {"gain": 1}, "was frequency_ratio: 0.8"),
        ("end_point: {frequency_ratio: 0.8, gain: 1}  # all of it\n", {"gain": 1}, "# all of it; was frequency_ratio: 0.8"),
        ("end_point: {frequency_ratio: 0.8}\n", {}, "was frequency_ratio: 0.8"),
        ("end_point:\n  frequency_ratio: 0.8\n", {}, "frequency_ratio: 0.8"),
        ("end_point:\n  frequency_ratio: 0.8", {}, "frequency_ratio: 0.8"),
    ],
)
def test_a_key_that_is_gone_becomes_a_comment(text: str, wanted: dict[str, float], kept: str) -> None:
    after, done = migrated(text)
    assert yaml.safe_load(after)["end_point"] == wanted
    assert kept in after
    assert [each.path for each in done] == ["end_point.frequency_ratio"]


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("devices:\n  v:\n    driver: x\n    options:\n      node: 4\n      demand_proof: false  # no pump\n", {"node": 4}),
        ("devices:\n  v:\n    driver: x\n    options:\n      demand_proof: false  # no pump\n    timeout: 1 s\n", {}),
        ("devices:\n  v:\n    driver: x\n    options: {demand_proof: false, node: 4}  # no pump\n", {"node": 4}),
        ("devices:\n  v: {driver: x, options: {node: 4, demand_proof: false}}  # no pump\n", {"node": 4}),
    ],
)
def test_the_demand_of_a_proof_moves_to_the_device(text: str, options: dict[str, int]) -> None:
    after, done = migrated(text)
    device = yaml.safe_load(after)["devices"]["v"]
    before = yaml.safe_load(text)["devices"]["v"]
    assert device == {**before, "options": options, "demand_proof": False}
    assert "# no pump" in after
    assert [each.path for each in done] == ["devices.v.options.demand_proof"]
    assert migrated(after) == (after, []), "once is enough"


def test_every_device_of_a_real_file_is_moved_and_it_loads() -> None:
    text = CAN.replace("      node: 11\n", "      node: 11\n      demand_proof: false\n").replace(
        "      node: 12\n", "      node: 12\n      demand_proof: false       # [A]\n"
    )
    assert text.count("demand_proof") == CAN.count("demand_proof") + 2
    after, done = migrated(text)
    assert len(done) == 2
    rig = rig_from_text(after)
    assert rig.devices["rotary_valve"].demand_proof is False
    assert rig.devices["prismatic_valve"].demand_proof is False
    comments = [line.partition("#")[2] for line in CAN.splitlines() if "#" in line]
    assert all(comment in after for comment in comments)


def test_each_migration_is_tried_here() -> None:
    """Whoever adds one adds its test: this names those that have one."""
    assert [migration.key for migration in MIGRATIONS] == [
        "devices.NAME.options.demand_proof", "end_point.frequency_ratio", "end_point.friction_gain in V*s/rad",
    ]  # fmt: skip


@pytest.mark.parametrize(("mark", "newline"), [("", "\n"), (BOM, "\r\n")])
def test_a_file_is_rewritten_with_a_copy_of_the_old_one(tmp_path: Path, mark: str, newline: str) -> None:
    rig = tmp_path / "rig.yaml"
    before = (mark + OLD.read_text().replace("\n", newline)).encode()
    rig.write_bytes(before)
    rig.chmod(0o640)
    (tmp_path / "rig.yaml.old").write_text("an older one")
    done = migrate_file(rig)
    assert done.backup == tmp_path / "rig.yaml.old-2"
    assert done.backup.read_bytes() == before
    after = rig.read_bytes()
    assert after.startswith(mark.encode())
    assert after.count(newline.encode()) == before.count(newline.encode()) == after.count(b"\n")
    assert rig.stat().st_mode & 0o777 == 0o640
    assert {path.name for path in tmp_path.iterdir()} == {"rig.yaml", "rig.yaml.old", "rig.yaml.old-2"}
    assert migrate_file(rig).backup is None


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "real.yaml").write_bytes(OLD.read_bytes())
    (tmp_path / "link.yaml").symlink_to("real.yaml")
    migrate_file(tmp_path / "link.yaml")
    assert (tmp_path / "link.yaml").is_symlink()
    assert "was 0.0232072" in (tmp_path / "real.yaml").read_text()


def test_what_cannot_be_replaced_stays_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rig = tmp_path / "rig.yaml"
    rig.write_bytes(OLD.read_bytes())

    def full(source: object, target: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(ConfigError, match="No space left"):
        migrate_file(rig)
    assert rig.read_bytes() == OLD.read_bytes()
    assert not list(tmp_path.glob(".*"))


def test_check_tells_of_older_keys_and_migrates_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig = tmp_path / "rig.yaml"
    rig.write_bytes(OLD.read_bytes())
    assert main(["check", str(rig)]) != 0
    assert f"`longreach check {rig} --migrate` rewrites them" in capsys.readouterr().err
    assert rig.read_bytes() == OLD.read_bytes()
    assert main(["check", str(rig), "--migrate"]) == 0
    assert "1 place rewritten" in capsys.readouterr().out
    assert main(["check", str(rig), "--migrate"]) == 0
    assert "nothing to migrate" in capsys.readouterr().out
