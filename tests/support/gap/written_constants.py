"""The constants of a written rig file, read by themselves: YAML and pint, without the loader."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pint
import yaml

UNITS: pint.UnitRegistry[float] = pint.UnitRegistry()


def in_file(path: Path, key: str) -> tuple[float, str] | None:
    """Number and unit at a key as findings.json has it ("plant.sensors.axis.position.bias"); None where the file does not have it."""
    node: Any = yaml.safe_load(path.read_text())
    words = key.split(".")
    while words:
        count = next((n for n in range(len(words), 0, -1) if isinstance(node, dict) and ".".join(words[:n]) in node), 0)
        if count:
            node = node[".".join(words[:count])]
        elif isinstance(node, list):
            node, count = node[int(words[0])], 1
        else:
            return None
        words = words[count:]
    found = re.match(r"\s*([-+.\deE]+)\s*(.*)$", str(node))
    assert found, node
    return float(found[1]), found[2]


def differing(content: dict[str, Any], path: Path) -> list[str]:
    """Constants of the table whose value is not the file's, to the five digits that both have."""
    wrong = []
    for key, item in content["parameters"].items():
        found = in_file(path, key)
        if found is None:
            wrong += [] if item["value"] == item["prior"]["value"] else [f"{key}: not in the file"]
            continue
        value, unit = found
        said = UNITS.Quantity(value, unit or item["unit"]).to(item["unit"] or "dimensionless").magnitude
        if abs(said - item["value"]) > 1e-5 * abs(said):
            wrong.append(f"{key}: {said} {item['unit']} in the file, {item['value']} in the table")
    return wrong
