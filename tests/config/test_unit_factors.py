"""The table of factors against pint, which is what it stands for: each number bit for bit, and nothing of a dimension left out."""

from __future__ import annotations

import os
import random
import subprocess
import sys
from itertools import product
from pathlib import Path

import pytest

from config import pint_units, unit_factors
from config.loading.shipped import shipped
from config.units import from_si, to_si

_DIFFERENCES = {"K": "delta_degC", "K/s": "delta_degC/s"}  # pint's way to write a difference of temperatures


def _pint_unit(stored: str, written: str) -> str:
    if stored not in _DIFFERENCES or not written.startswith("deg"):
        return written
    return f"delta_{written}"


@pytest.mark.slow
@pytest.mark.parametrize("seed", ["0", "17"])
def test_the_file_is_what_pint_says_now(seed: str) -> None:
    say = "from config.pint_units import table_text; print(table_text(), end='')"
    environment = {**os.environ, "PYTHONHASHSEED": seed}
    text = subprocess.run([sys.executable, "-c", say], capture_output=True, text=True, check=True, env=environment).stdout
    assert text == Path(unit_factors.__file__).read_text(encoding="utf-8"), "run python -m config.pint_units"


@pytest.mark.parametrize("stored", sorted(unit_factors.FACTORS))
def test_a_number_is_converted_as_by_pint_to_the_last_bit(stored: str) -> None:
    numbers = random.Random(stored)
    values = (0.0, 1.0, *(numbers.uniform(-1, 1) * 10 ** numbers.randint(-6, 6) for _ in range(20)))
    for value, written in product(values, filter(None, unit_factors.FACTORS[stored])):
        theirs = pint_units.converted(value, _pint_unit(stored, written), _DIFFERENCES.get(stored, stored))
        assert to_si(f"{value!r} {written}", stored) == theirs
        assert to_si(f"{from_si(value, stored, written)!r} {written}", stored) == pytest.approx(value, rel=1e-15, abs=1e-300)


@pytest.mark.parametrize("written", sorted(unit_factors.TEMPERATURES))
def test_temperatures_too(written: str) -> None:
    for value in (-40.0, 0.1, 37.3, 212.0):
        assert to_si(f"{value} {written}", "degC") == pint_units.converted(value, written, "degC")
        assert from_si(value, "degC", written) == pint_units.converted(value, "degC", written)


def test_what_the_table_leaves_out_is_of_another_dimension() -> None:
    units = pint_units.registry()
    of_unit = {unit: units.Unit(unit or "dimensionless").dimensionality for unit in pint_units.written_units()}
    for stored, known in unit_factors.FACTORS.items():
        alike = {unit for unit, dimension in of_unit.items() if dimension == of_unit[stored]}
        if stored == "degC":
            assert not known  # temperatures have offsets, and a table of their own
        elif stored in _DIFFERENCES:
            assert alike <= known.keys() | {"degC"}
        else:
            assert alike == known.keys()


def test_no_shipped_file_needs_pint() -> None:
    load = "from config.loading.load import load_maneuver, load_rig\nfrom config.loading.shipped import shipped\nimport sys\n"
    load += "[load_rig(name) for name in shipped('rigs')]; [load_maneuver(name) for name in shipped('maneuvers')]\n"
    load += "print(*sorted({name.partition('.')[0] for name in sys.modules} & {'pint', 'numpy', 'dask', 'babel', 'matplotlib'}))"
    assert shipped("rigs")
    assert subprocess.run([sys.executable, "-c", load], capture_output=True, text=True, check=True).stdout.strip() == ""
