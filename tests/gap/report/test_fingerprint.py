"""Against what an effect is drawn: its own variable, or the reading of its sensor."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from config.loading.load import load_rig
from config.schema.effect_library import EFFECTS
from config.schema.rig import Rig
from gap.report import fingerprint
from gap.report.fingerprint import abscissa, fingerprint_of
from gap.report.shown import fingerprints, telling_channel

SHAPE = (6, 40)
CHANNELS = ["rotary.position", "prismatic.position", "rotary.supply_pressure", "tip.acceleration", "tip.deflection"]


@cache
def _testbed() -> Rig:
    return load_rig("ornl_testbed").rig


def drawn_over(monkeypatch: pytest.MonkeyPatch, effect: str, where: str) -> Any:
    """The abscissa of an effect; readings are the number of their channel, the joints' own variables run up by 1 a sample."""
    rig = _testbed()
    own = np.broadcast_to(np.arange(SHAPE[1], dtype=float), SHAPE)
    known = {f"{joint}.{kind}": own for joint in rig.joints for kind in ("position", "velocity", "command_V")}
    monkeypatch.setattr(fingerprint, "operating_values", lambda evaluation, rig: known)
    monkeypatch.setattr(fingerprint, "_reading", lambda evaluation, channel: np.full(SHAPE, float(CHANNELS.index(channel))))
    seen: Any = SimpleNamespace(experiment=SimpleNamespace(plan=SimpleNamespace(every=2), log=SimpleNamespace(period_s=1e-3)))
    return abscissa(seen, fingerprint_of(effect, where, CHANNELS, "rotary.position", rig).variable, rig)


@pytest.mark.parametrize("where", [*(f"sensor:{name}" for name in CHANNELS), "rotary", "prismatic", "link", "supply"])
@pytest.mark.parametrize("effect", EFFECTS)
def test_every_effect_has_a_variable_at_every_place(monkeypatch: pytest.MonkeyPatch, effect: str, where: str) -> None:
    assert drawn_over(monkeypatch, effect, where).shape == SHAPE


def test_an_accelerometer_at_the_tip_is_a_sensor_and_not_the_acceleration_of_a_joint(monkeypatch: pytest.MonkeyPatch) -> None:
    assert np.all(drawn_over(monkeypatch, "sensor_scale", "sensor:tip.acceleration") == CHANNELS.index("tip.acceleration"))
    assert drawn_over(monkeypatch, "inertia_error", "rotary") == pytest.approx(500.0)  # 1 rad/s more every 2 ms


def found_with(costs: list[list[float]]) -> Any:
    """An outcome on hold-out logs with these costs of each channel (NaN: it is lacking); its effect is at the second channel's sensor."""
    candidate = SimpleNamespace(effect="sensor_scale", where=f"sensor:{CHANNELS[1]}", label="scale")
    return SimpleNamespace(
        channels=CHANNELS,
        nominal=[SimpleNamespace(channel_costs=np.array(row)) for row in costs],
        places=[],
        state=SimpleNamespace(named=[SimpleNamespace(suspect=candidate)]),
        rig=load_rig("ornl_testbed"),
    )


def test_an_effect_at_a_sensor_that_the_hold_out_lacks_is_drawn_in_a_channel_it_has() -> None:
    lacking = found_with([[np.nan, np.nan, 2.0, 3.0, 4.0]])
    assert telling_channel(lacking) == 2
    ((label, what),) = fingerprints(lacking)
    assert (label, what.channel) == ("scale", CHANNELS[2])
    having = found_with([[np.nan, np.nan, 2.0, 3.0, 4.0], [1.0, 5.0, 2.0, 3.0, 4.0]])
    assert fingerprints(having)[0][1].channel == CHANNELS[1]


def test_a_log_that_lacks_a_reading_has_none_to_draw_over() -> None:
    plan = SimpleNamespace(starts=np.array([0, 10]), every=2, samples=5)
    log = SimpleNamespace(channels={"rotary.position": SimpleNamespace(values=np.arange(40.0))}, period_s=1e-3)
    seen: Any = SimpleNamespace(experiment=SimpleNamespace(plan=plan, log=log))
    assert fingerprint._reading(seen, "rotary.position")[1] == pytest.approx([10, 12, 14, 16, 18])
    assert np.isnan(fingerprint._reading(seen, "tip.deflection")).all()
