"""The measured axis once more, with the window and the measure of the reference: 0.25 s, offset and slope of each window taken out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import detrend

from gap.find import find
from gap.settings import Settings
from tests.support.gap import emps_logs


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_the_hold_out_error_as_the_reference_counts_it(tmp_path: Path) -> None:
    """Reference: 145.4 µm before, 68.9 with Coulomb friction, 25.6 with asymmetric friction, then nothing more (gap reference C.2)."""
    fit_log, holdout = emps_logs.logs(tmp_path)
    settings = Settings(window_s=0.25, propose=False)
    found = find(emps_logs.frictionless(tmp_path), [fit_log], [holdout], tmp_path / "out", lambda line: None, settings)
    assert [f["effect"] for f in found.content["findings"]] == ["coulomb_friction", "asymmetric_friction"]
    assert found.content["findings"][0]["parameters"]["friction"]["value"] == pytest.approx(20.39, rel=0.06)
    errors = np.concatenate([(e.experiment.measured - e.readings)[:, :, 0] for e in found.final])
    assert np.sqrt(np.mean(detrend(errors, axis=1) ** 2)) <= 26e-6
