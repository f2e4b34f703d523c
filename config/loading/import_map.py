"""Import maps: how the columns of somebody's table become the columns of a log.

longreach: map/1
name: bench
joints: {boom: rotary}
columns:
  t_s: {source: time, unit: ms}
  boom.position: {source: angle, unit: deg, offset: -90}
  boom.command_V: {source: u}
constants: {boom.supply_pressure_Pa: 2000 psi}
ignored: [comment]
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, cast

from pydantic import Field

from config.loading.load import read_text
from config.loading.shipped import find
from config.parsing.problems import config_error
from config.parsing.validation import validated
from config.parsing.yaml_tree import YamlTree, parse
from config.schema.section import Section


class SourceColumn(Section):
    """Where one column of the log comes from: (offset + scale × number in the table), in `unit`, converted to the log's unit."""

    source: str = Field(description="name of the column in the table")
    unit: str | None = Field(None, description="unit of the number after scale and offset; the log's own unit by default")
    scale: float = Field(1.0, allow_inf_nan=False, description="factor on the number in the table")
    offset: float = Field(0.0, allow_inf_nan=False, description="added after the factor, in `unit`")


class ImportMap(Section):
    """One way of reading tables. Keys of `columns` and `constants` are names of the log, e.g. `rotary.command_V`."""

    longreach: Literal["map/1"] = Field(description="kind and version of this file")
    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$")]
    description: str = ""
    rig: str = Field("", description="name of the rig the data are from")
    joints: dict[Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]*$")], Literal["rotary", "linear"]] = Field(min_length=1)
    columns: dict[str, SourceColumn] = Field(min_length=1, description="log column: where it comes from")
    constants: dict[str, str | float] = Field(default_factory=dict, description="log column: the same value in every row")
    ignored: tuple[str, ...] = Field((), description="columns of the table that are left out on purpose")


@dataclass(frozen=True, slots=True)
class LoadedMap:
    """A map, the text it came from (it goes into the log), and its tree for messages with line and column."""

    map: ImportMap
    text: str
    path: str
    tree: YamlTree


def load_map(path: str | Path) -> LoadedMap:
    """Load a map file, given as a path or as the name of a shipped map ("emps"). ConfigError lists every problem."""
    file = find("maps", path)
    text = read_text(file)
    tree = parse(text, str(file))
    found, problems = validated(ImportMap, tree)
    if problems or tree.problems:
        raise config_error(tree.name, [*tree.problems, *problems])
    return LoadedMap(cast(ImportMap, found), text, str(file), tree)
