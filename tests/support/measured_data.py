"""Where the measured public data are: beside the checkout, and not part of it. Tests that want them skip where they are absent."""

from __future__ import annotations

from pathlib import Path

MEASURED_DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
EMPS = MEASURED_DATA / "emps"
