"""The `identified:` section of a rig file: numbers of `link_mode` are taken from a calibration record when the file is loaded.

The text that is loaded, logged and re-executed holds the numbers themselves, so a log needs no second file.
"""

from __future__ import annotations

from pathlib import Path

from config.errors import ConfigError
from config.loading.calibration_record import CalibrationRecord, LinkCalibration, load_record
from config.loading.overrides import apply_overrides
from config.parsing.problems import config_error
from config.parsing.yaml_tree import YamlTree, parse

USES = ("payload", "frequency_map", "damping_ratio")


def record_path(record: str, rig_file: Path) -> Path:
    """A record's path counts from the rig file's directory."""
    return rig_file.parent / Path(record).expanduser()


def with_identified(text: str, rig_file: Path) -> str:
    """The rig text with the referred record's numbers in `link_mode`; unchanged without a reference. `text` is a valid rig file.

    ConfigError at the reference when the record is missing, of another rig, or lacks what is to be used.
    """
    tree = parse(text, str(rig_file))
    reference = tree.value(("identified",))
    if reference is None:
        return text
    path = record_path(str(reference["record"]), rig_file)
    try:
        record = load_record(path)
    except ConfigError as error:
        raise _at(tree, "record", f"identified.record cannot be used: {error}", str(path)) from error
    rig = tree.value(("name",))
    if record.rig != rig:
        raise _at(tree, "record", f"the calibration record is of the rig {record.rig!r}, this is {rig!r}", str(path))
    wanted = reference.get("use")
    return apply_overrides(text, [_override(tree, record, use) for use in (_held(tree, record) if wanted is None else wanted)])


def _held(tree: YamlTree, record: CalibrationRecord) -> list[str]:
    """What the record has: one move gives the payload and a frequency, no damping."""
    found = [use for use in USES if record.link is not None and _value(record.link, use) is not None]
    if not found:
        raise _at(tree, "record", "the calibration record has nothing about the link", str(tree.value(("identified", "record"))))
    return found


def _override(tree: YamlTree, record: CalibrationRecord, use: str) -> str:
    link = record.link
    value = _value(link, use) if link is not None else None
    if value is None:
        raise _at(tree, "use", f"the calibration record has no {use}", str(tree.value(("identified", "record"))))
    return f"link_mode.{use}={value}"


def _value(link: LinkCalibration, use: str) -> str | None:
    if use == "payload":
        return f"{link.payload_kg!r} kg"
    if use == "damping_ratio":
        return None if link.damping_ratio is None else repr(link.damping_ratio)
    points = [f"{{extension: {point.extension_m!r} m, frequency: {point.frequency_Hz!r} Hz}}" for point in link.frequency_map]
    return f"[{', '.join(points)}]" if points else None


def _at(tree: YamlTree, key: str, what: str, value: str) -> ConfigError:
    path = ("identified", key) if tree.value(("identified", key)) is not None else ("identified",)
    advice = "Make one with `longreach identify`, or remove the reference."
    return config_error(tree.name, [tree.problem(path, what, value=value, next_step=advice)])
