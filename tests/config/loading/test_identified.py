"""A rig file that refers to a calibration record: numbers taken, shown by check, refused with their place, and whole in the text."""

from __future__ import annotations

import datetime
from pathlib import Path

import pytest

from config.checking.check import check_rig
from config.errors import ConfigError
from config.loading.load import find, load_rig, rig_from_text
from servo_control.link.link_mode import LinkFrequency

RECORD = """\
longreach: calibration/1
rig: ornl_testbed
identified_on: 2026-11-21
valid_until: 2027-05-20
by: operator@bench
software: longreach 0.1.0
source: simulated
logs: {a.mcap: 00ff}
link:
  payload: 30 lb
  payload_uncertainty: 0.1 kg
  damping_ratio: 0.006
  frequency_map:
    - {extension: 30 in, frequency: 6.0 Hz}
    - {extension: 50 in, frequency: 2.9 Hz}
"""


def _rig(directory: Path, use: str = "", record: str | None = RECORD) -> Path:
    rig = directory / "rig.yaml"
    rig.write_text(find("rigs", "ornl_testbed").read_text() + f"\nidentified: {{record: records/now.yaml{use}}}\n")
    (directory / "records").mkdir()
    if record is not None:
        (directory / "records" / "now.yaml").write_text(record)
    return rig


def test_the_link_has_the_recorded_numbers_and_the_text_holds_them(tmp_path: Path) -> None:
    loaded = load_rig(_rig(tmp_path))
    link = loaded.rig.link_mode
    assert link is not None
    assert (link.payload_kg, link.damping_ratio) == (pytest.approx(30 * 0.45359237), 0.006)
    frequency = LinkFrequency(link)
    assert [frequency.frequency_Hz(inches * 0.0254) for inches in (30, 50)] == pytest.approx([6.0, 2.9])
    (tmp_path / "records" / "now.yaml").unlink()
    assert rig_from_text(loaded.text).link_mode == link  # as a log does: without the record


def test_between_points_the_formula_is_followed() -> None:
    """Measured = computed × a ratio that goes on a straight line from 0.98 to 0.96, and is constant beyond."""
    link = load_rig("ornl_testbed").rig.link_mode
    assert link is not None
    formula = LinkFrequency(link)
    points = [{"extension": x, "frequency": ratio * formula.frequency_Hz(x)} for x, ratio in ((0.8, 0.98), (1.2, 0.96))]
    mapped = LinkFrequency(type(link).model_validate({**link.model_dump(by_alias=True), "frequency_map": points}), 1.1)
    for x, ratio in ((0.5, 0.98), (0.8, 0.98), (1.0, 0.97), (1.1, 0.965), (1.5, 0.96)):
        assert mapped.frequency_Hz(x) == pytest.approx(1.1 * ratio * formula.frequency_Hz(x), rel=1e-12)


def test_only_what_is_asked_for_is_taken(tmp_path: Path) -> None:
    link = load_rig(_rig(tmp_path, ", use: [payload]")).rig.link_mode
    assert link is not None
    assert link.payload_kg == pytest.approx(30 * 0.45359237)
    assert (link.frequency_map, link.damping_ratio) == ((), 0.005)


def test_what_the_record_lacks_is_left_as_the_rig_file_has_it(tmp_path: Path) -> None:
    """`identify --what payload` sees one move, and so no damping."""
    link = load_rig(_rig(tmp_path, "", RECORD.replace("  damping_ratio: 0.006\n", ""))).rig.link_mode
    assert link is not None
    assert link.payload_kg == pytest.approx(30 * 0.45359237)
    assert (len(link.frequency_map), link.damping_ratio) == (2, 0.005)


def test_check_shows_the_record_and_that_it_has_expired(tmp_path: Path) -> None:
    loaded = load_rig(_rig(tmp_path))
    texts = {
        day.year: [f"{each.level} {each.text}" for each in check_rig(loaded, day)]
        for day in (datetime.date(2026, 12, 1), datetime.date(2028, 1, 1))
    }
    assert any("payload 13.608 ± 0.100 kg, 2 extensions" in text and "operator@bench" in text for text in texts[2026])
    assert not any("valid until" in text for text in texts[2026])
    assert any(text.startswith("warning") and "was valid until 2027-05-20" in text for text in texts[2028])


@pytest.mark.parametrize(
    ("use", "record", "text"),
    [
        ("", None, "the calibration record cannot be read"),
        ("", RECORD.replace("30 lb", "30 m"), "records/now.yaml:10:12"),
        ("", RECORD.replace("rig: ornl_testbed", "rig: other"), "is of the rig 'other', this is 'ornl_testbed'"),
        (", use: [damping_ratio]", RECORD.replace("  damping_ratio: 0.006\n", ""), "the calibration record has no damping_ratio"),
    ],
)
def test_what_cannot_be_used_is_refused_at_the_reference(tmp_path: Path, use: str, record: str | None, text: str) -> None:
    with pytest.raises(ConfigError) as caught:
        load_rig(_rig(tmp_path, use, record))
    assert text in str(caught.value)
    assert "rig.yaml:" in str(caught.value)
