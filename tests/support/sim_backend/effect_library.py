"""Libraries of effects that somebody else has written, installed for processes of their own; one effect at every hook of the kernel."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

CHECKOUT = Path(__file__).parents[3]

HOSE_SWELLING = '''"""A hose that swells with the square of pressure: 1/β_e = … + c P²."""

from __future__ import annotations

from typing import Literal

from config.schema.effect import Case, Effect, Equation, Hook, Law, Search, up
from config.schema.effect_entry import HydraulicEntry
from config.schema.section import quantity


class HoseSwelling(HydraulicEntry):
    effect: Literal["hose_swelling"]
    swelling: float = quantity("1/Pa^3", "relative volume change of the hoses per pressure, per squared pressure", low=0, high=1e-20)


def swollen(compliance: float, pressure_Pa: float, swelling: float) -> float:
    return compliance + swelling * pressure_Pa**2


EFFECT = Effect(
    entry=HoseSwelling,
    law=Law(Hook.COMPLIANCE, swollen, ("swelling",)),
    neutral={"swelling": 0.0},
    search=Search(Equation.FLOW, (up("swelling", lambda s: 3e-10 / s.pressure**2, 100, (1.0, 4.0)),)),
    variable="acceleration",
    fingerprint="The hydraulic resonance is lower at high pressure.",
    look_alikes={"hose_compliance": "hoses are as soft at low pressure", "entrained_air": "air is soft at low pressure"},
    cases=(Case("rotary", {"swelling": "2e-23 1/Pa^3"}, "rotary.position"),),
)
'''


@dataclass(frozen=True)
class Short:
    """An effect at one of the other hooks: what is different about its file."""

    hook: str
    arguments: str  # of its law
    law: str
    size: float
    signal: str  # that must change with it
    where: str = "rotary"
    base: str = "JointEntry"
    equation: str = "FORCE"

    def file(self, name: str) -> str:
        return f'''"""{name}: {self.law}"""

import math
from typing import Literal

from config.schema.effect import Case, Effect, Equation, Hook, Law, Search, up
from config.schema.effect_entry import {self.base}
from config.schema.section import quantity


class Entry({self.base}):
    effect: Literal["{name}"]
    size: float = quantity("", "how strong it is", low=0, high=1e9)


def law({self.arguments}):
    return {self.law}


EFFECT = Effect(
    entry=Entry,
    law=Law(Hook.{self.hook}, law, ("size",)),
    neutral={{"size": 0.0}},
    search=Search(Equation.{self.equation}, (up("size", lambda s: {self.size} / 10, 100),)),
    fingerprint="It shows.",
    look_alikes={{}},
    cases=(Case("{self.where}", {{"size": {self.size}}}, "{self.signal}"),),
)
'''


ORIFICE = "flow + size * math.copysign(math.sqrt(abs(a - b)), a - b)"
ROUGH = "level + size * abs(difference) ** 0.5"
OTHERS = {
    "turbulent_leakage": Short("LEAKAGE", "flow, a, b, size", ORIFICE, 1e-9, "rotary.position", base="HydraulicEntry", equation="FLOW"),
    "rough_seal": Short("FRICTION", "level, velocity, difference, size", ROUGH, 0.5, "prismatic.position", where="prismatic"),
    "return_spring": Short("FORCE", "force, position, velocity, size", "force - size * position", 2000.0, "rotary.position"),
    "bent_command": Short(
        "SPOOL_COMMAND", "spool, command_V, size", "spool + size * spool * abs(spool)", 0.5, "rotary.position", equation="VALVE"
    ),
    "soft_supply": Short(
        "SUPPLY", "pressure, flow, size", "pressure - size * flow", 1e9, "rotary.supply_pressure", "supply", "SupplyEntry", "SUPPLY"
    ),
    "second_leaf": Short(
        "BENDING", "force, tip, tip_rate, length, size", "force - size * tip", 1000.0, "tip.deflection", "link", "LinkEntry", "LINK"
    ),
    "bent_sensor": Short(
        "READING", "reading, value, size", "reading + size * value * value", 0.1, "raw", "sensor:rotary.position", "SensorEntry", "SENSOR"
    ),
}


@dataclass(frozen=True)
class Installed:
    """A process's environment in which a library is installed."""

    environment: Mapping[str, str]

    def run(self, *arguments: str) -> str:
        done = subprocess.run([sys.executable, *arguments], cwd=CHECKOUT, env=dict(self.environment), capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout


def installed(folder: Path, files: Mapping[str, str]) -> Installed:
    package = folder / "hoses_of_somebody"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text('"""Effects of somebody else."""\n')
    for name, text in files.items():
        (package / f"{name}.py").write_text(text)
    metadata = folder / "hoses_of_somebody-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: hoses-of-somebody\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text("[longreach.effects]\nhoses = hoses_of_somebody\n")
    path = os.pathsep.join([str(folder), str(CHECKOUT)])
    return Installed({**os.environ, "PYTHONPATH": path, "CACHE_DIRECTORY": str(folder / "kernel")})


def rig_text(entry: str) -> str:
    """The testbed with one more effect."""
    text = (CHECKOUT / "config" / "rigs" / "ornl_testbed.yaml").read_text()
    return text.replace("  effects:\n", f"  effects:\n    - {{{entry}}}\n")
