"""The words of a start request against the maneuver they make."""

from __future__ import annotations

import yaml

from daemon.server.start_request import start_run
from tests.support.daemon.rigs import RIG


def test_a_parameter_of_an_excitation_leaves_its_other_keys_as_they_are() -> None:
    """`on` is a key of these files and a truth value of YAML 1.1."""
    request = {"maneuver": {"name": "multisine"}, "parameters": {"amplitude": "0.3 V", "on": "command"}, "approach": True}
    start = start_run(RIG.rig, 1, request, [0.0, 0.9144])
    content = start.plan.request.maneuver
    assert (content["on"], content["amplitude"]) == ("command", "0.3 V")
    assert yaml.safe_load(start.maneuver_yaml)["on"] == "command"
