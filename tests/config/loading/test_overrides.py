"""What-if changes to a rig text: the value changes, everything else stays letter for letter."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import pytest

from config.errors import ConfigError
from config.loading.load import apply_overrides, load_rig, rig_from_text
from config.options.canopen_rig import canopen_devices, proofs
from config.options.driver_options import device_options
from config.schema.rig import Rig
from tests.support.config.small_rig import SMALL, changed


def test_a_value_changes_and_its_comment_stays() -> None:
    text = load_rig("ornl_testbed").text
    before = re.search(r"gain: (\S+ V/deg)", text)
    assert before is not None
    after = apply_overrides(text, ["servo.rotary.gain=0.27 V/deg"])
    differing = [(old, new) for old, new in zip(text.splitlines(), after.splitlines(), strict=True) if old != new]
    assert len(differing) == 1
    assert differing[0][1] == differing[0][0].replace(before[1], "0.27 V/deg", 1)
    assert rig_from_text(after).servo["rotary"].gain == pytest.approx(0.27 * 180 / math.pi)


@pytest.mark.parametrize(
    ("assignment", "old", "new"),
    [
        ("loop.rate=1 kHz", "rate: 500 Hz", "rate: 1 kHz"),
        ("loop.cpu=1", "  rate: 500 Hz", "  cpu: 1\n  rate: 500 Hz"),  # not written so far: goes to the head of its section
        ("loop.overruns.stop_after=5", "{window: 2 s}", "{stop_after: 5, window: 2 s}"),
        ("joints.axis.travel.1=40 in", "48 in]", "40 in]"),
        ("joints.axis.travel=[1 in, 40 in]", "[0 in, 48 in]", "[1 in, 40 in]"),
        ("signals.axis.position.max_age=9 ms", "axis.position:\n    device", "axis.position:\n    max_age: 9 ms\n    device"),
        ("signals.axis.position.calibration.offset=1 in", "{scale: 25 um}", "{offset: 1 in, scale: 25 um}"),
        ("description=a text", "longreach: rig/1", "description: a text\nlongreach: rig/1"),
        ("link_mode.payload=45 lb", "longreach: rig/1", "link_mode: {payload: 45 lb}\nlongreach: rig/1"),
    ],
)
def test_where_a_value_goes(assignment: str, old: str, new: str) -> None:
    assert apply_overrides(SMALL, [assignment]) == changed((old, new))


@pytest.mark.parametrize(
    ("assignment", "option", "expected"),
    [
        ("devices.rotary_valve.options.node=42", lambda rig: canopen_devices(rig)["rotary_valve"].node, 42),
        ("devices.rotary_valve.options.missing_frames=40", lambda rig: canopen_devices(rig)["rotary_valve"].missing_frames, 40),
        ("devices.rotary_valve.options.heartbeat=50 ms", lambda rig: canopen_devices(rig)["rotary_valve"].heartbeat_s, 0.05),
        ("devices.rotary_valve.demand_proof=false", lambda rig: proofs(rig)["rotary_valve"], False),
        ("devices.rotary_valve.options.deadline=false", lambda rig: canopen_devices(rig)["rotary_valve"].deadline, False),
        ("devices.rotary_valve.options.bus.fault_cycles=9", lambda rig: canopen_devices(rig)["rotary_valve"].bus.fault_cycles, 9),
        ("devices.hydraulic_unit.options.port=1503", lambda rig: _gauges(rig).port, 1503),
        ("devices.hydraulic_unit.options.largest_gap=0", lambda rig: _gauges(rig).largest_gap, 0),
        (
            "devices.hydraulic_unit.options.channels.reservoir_temperature.type=uint16",
            lambda rig: _gauges(rig).channels["reservoir_temperature"].type,
            "uint16",
        ),
    ],
)
def test_the_options_of_a_device_are_reached_written_or_not(assignment: str, option: Callable[[Rig], Any], expected: object) -> None:
    rig = rig_from_text(apply_overrides(load_rig("ornl_testbed_can").text, [assignment]))
    assert option(rig) == expected


def _gauges(rig: Rig) -> Any:
    return device_options("hydraulic_unit", rig.devices["hydraulic_unit"])


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("rotary_valve.options.heartbaet", "'heartbaet' is not a key of devices.rotary_valve.options: nearest is 'heartbeat'"),
        ("rotary_valve.options.bus.bitrat", "'bitrat' is not a key of devices.rotary_valve.options.bus: nearest is 'bitrate'"),
        ("hydraulic_unit.options.baud_rate", "'baud_rate' is not a key of devices.hydraulic_unit.options"),  # of RTU, and this is TCP
        ("hydraulic_unit.options.channels.oil", "'oil' is not a key of devices.hydraulic_unit.options.channels"),
    ],
)
def test_an_option_the_driver_does_not_have_is_refused(key: str, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        apply_overrides(load_rig("ornl_testbed_can").text, [f"devices.{key}=1"])
    assert message in str(caught.value)


def test_a_section_with_nothing_in_it_can_be_filled() -> None:
    text = changed(("loop:\n  rate: 500 Hz\n  overruns: {window: 2 s}\n", "loop:\n"))
    assert rig_from_text(apply_overrides(text, ["loop.overruns.window=3 s"])).loop.overruns.window_s == 3.0


def test_several_are_applied_in_order() -> None:
    text = apply_overrides(SMALL, ["loop.rate=100 Hz", "loop.rate=200 Hz", "servo.axis.null_bias=0.1 V"])
    rig = rig_from_text(text)
    assert rig.loop.rate_Hz == 200.0
    assert rig.servo["axis"].null_bias_V == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("assignment", "message"),
    [
        ("servo.axis.gian=1", "override: servo.axis.gian: 'gian' is not a key of servo.axis: nearest is 'gain'. Keys of servo.axis: "),
        ("servo.axs.gain=1", "override: servo.axs.gain: 'axs' is not a key of servo: nearest is 'axis'. Keys of servo: axis."),
        ("sevro.axis.gain=1", "override: sevro.axis.gain: 'sevro' is not a key of a rig file: nearest is 'servo'. "),
        ("loop.rate.x=1", "override: loop.rate.x: 'x' is not a key of loop.rate"),
        ("joints.axis.travel.2=1 in", "override: joints.axis.travel.2: '2' is not a key of joints.axis.travel"),
        ("loop.rate", "an override is written key.path=value: 'loop.rate'. Example: servo.rotary.gain=0.5 V/deg"),
        ("loop.rate=", "an override is written key.path=value: 'loop.rate='. "),
        ("loop.rate=1 kHz # fast", "override loop.rate: an override is one line without a comment: '1 kHz # fast'"),
        ("loop.rate=[1", "override loop.rate:1:10: not readable as YAML"),
    ],
)
def test_refusals(assignment: str, message: str) -> None:
    with pytest.raises(ConfigError) as caught:
        apply_overrides(SMALL, [assignment])
    assert str(caught.value).startswith(message)


def test_a_value_outside_its_range_is_refused_when_the_result_is_loaded() -> None:
    with pytest.raises(ConfigError, match=r"what-if:6:9: loop.rate is out of range: 9 kHz"):
        rig_from_text(apply_overrides(SMALL, ["loop.rate=9 kHz"]), "what-if")
