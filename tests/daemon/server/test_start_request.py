"""The words of a start request against the maneuver they make."""

from __future__ import annotations

import pytest
import yaml

from config.errors import DaemonError, ManeuverError
from daemon.server.start_request import start_run, start_stream
from tests.support.daemon.rigs import RIG


def test_a_parameter_of_an_excitation_leaves_its_other_keys_as_they_are() -> None:
    """`on` is a key of these files and a truth value of YAML 1.1."""
    request = {"maneuver": {"name": "multisine"}, "parameters": {"amplitude": "0.3 V", "on": "command"}, "approach": True}
    start = start_run(RIG.rig, 1, request, [0.0, 0.9144])
    content = start.plan.request.maneuver
    assert (content["on"], content["amplitude"]) == ("command", "0.3 V")
    assert yaml.safe_load(start.maneuver_yaml)["on"] == "command"


def test_a_filter_with_an_option_that_it_does_not_use_is_refused() -> None:
    """Both of a program and by hand; what says nothing else than the usual may stand there."""
    request = {"maneuver": {"name": "jog"}, "shaper": {"kind": "zvd", "delay_s": 0.07}}
    for start in (start_run, start_stream):
        asked = {key: value for key, value in request.items() if start is start_run or key == "shaper"}
        with pytest.raises(ManeuverError, match=r"zvd does not use delay_s: 0\.07"):
            start(RIG.rig, 1, asked, [0.0, 0.9144])
        start(RIG.rig, 1, asked | {"shaper": {"kind": "zvd", "delay_s": None, "focal": "mid"}}, [0.0, 0.9144])


@pytest.mark.parametrize("parameters", [["by"], [{}], "by", {"start.rotary": "1 deg"}, ["start.rotary=1 deg"]])
def test_parameters_that_are_none_are_refused_as_such(parameters: object) -> None:
    with pytest.raises((ManeuverError, DaemonError), match=r"KEY=VALUE|a whole key of the maneuver: start\.rotary") as refusal:
        start_run(RIG.rig, 1, {"maneuver": {"name": "jog"}, "parameters": parameters}, [0.0, 0.9144])
    assert refusal.value.refusal.mend == ({"by": "by=2 deg"} if parameters == ["by"] else {})
