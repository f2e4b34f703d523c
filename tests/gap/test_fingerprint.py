"""Against what an effect is drawn: its own variable, or the reading of its sensor."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from config.load import load_rig
from gap.report import fingerprint
from gap.report.fingerprint import VARIABLE, abscissa, fingerprint_of

SHAPE = (6, 40)
CHANNELS = ["rotary.position", "prismatic.position", "rotary.supply_pressure", "tip.acceleration", "tip.deflection"]


def drawn_over(monkeypatch: pytest.MonkeyPatch, effect: str, where: str) -> Any:
    """The abscissa of an effect; readings are the number of their channel, the joints' own variables run up by 1 a sample."""
    rig = load_rig("ornl_testbed").rig
    own = np.broadcast_to(np.arange(SHAPE[1], dtype=float), SHAPE)
    known = {f"{joint}.{kind}": own for joint in rig.joints for kind in ("position", "velocity", "command_V")}
    monkeypatch.setattr(fingerprint, "operating_values", lambda evaluation, rig: known)
    monkeypatch.setattr(fingerprint, "_reading", lambda evaluation, channel: np.full(SHAPE, float(CHANNELS.index(channel))))
    seen: Any = SimpleNamespace(experiment=SimpleNamespace(plan=SimpleNamespace(every=2), log=SimpleNamespace(period_s=1e-3)))
    return abscissa(seen, fingerprint_of(effect, where, CHANNELS, "rotary.position", rig).variable, rig)


@pytest.mark.parametrize("where", [*(f"sensor:{name}" for name in CHANNELS), "rotary", "prismatic", "link", "supply"])
@pytest.mark.parametrize("effect", VARIABLE)
def test_every_effect_has_a_variable_at_every_place(monkeypatch: pytest.MonkeyPatch, effect: str, where: str) -> None:
    assert drawn_over(monkeypatch, effect, where).shape == SHAPE


def test_an_accelerometer_at_the_tip_is_a_sensor_and_not_the_acceleration_of_a_joint(monkeypatch: pytest.MonkeyPatch) -> None:
    assert np.all(drawn_over(monkeypatch, "sensor_scale", "sensor:tip.acceleration") == CHANNELS.index("tip.acceleration"))
    assert drawn_over(monkeypatch, "inertia_error", "rotary") == pytest.approx(500.0)  # 1 rad/s more every 2 ms
