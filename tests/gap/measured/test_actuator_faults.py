"""Measured hydraulic rotary actuators, one damaged unit a fault, no command and no scaling: nothing may be named."""

from __future__ import annotations

from pathlib import Path

import pytest

from config.errors import EXIT_UNUSABLE_DATA, LogError
from tests.support.gap import measured_logs


@pytest.mark.parametrize("fault", ["seal_defect_0", "gear_damage_0", "baseline6_0"])
def test_the_search_abstains_and_says_why(tmp_path: Path, fault: str) -> None:
    made = measured_logs.logs(tmp_path, "rotary_hydraulic_actuator_faults", "rotary_actuator", ["baseline1_0", fault])
    with pytest.raises(LogError) as caught:
        measured_logs.findings(tmp_path, "rotary_actuator", made[:1], made[1:])
    assert caught.value.exit_status == EXIT_UNUSABLE_DATA
    assert "the log has no shaft.command_V" in str(caught.value)
    assert "no effect of the drive is identifiable" in str(caught.value)
    assert not (tmp_path / "out").exists()
