"""Effects act in whatever order a rig file lists them."""

from __future__ import annotations

from itertools import permutations

import numpy as np

from config.loading.load import load_rig
from config.schema.effect_library import EFFECTS
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.layout import C


def test_what_is_added_does_not_hang_on_where_it_stands_in_the_file() -> None:
    """Damping that is added to a link stood before the entry that sets the link's own, and was lost."""
    rig = load_rig("ornl_testbed").rig
    assert rig.plant is not None
    more = [
        EFFECTS["link_damping_error"].entry.model_validate({"effect": "link_damping_error", "where": "link", "extra": 0.02}),
        EFFECTS["payload_error"].entry.model_validate({"effect": "payload_error", "where": "link", "extra": "2 kg"}),
    ]
    flexible = next(entry for entry in rig.plant.effects if entry.effect == "link_flexibility")
    others = tuple(entry for entry in rig.plant.effects if entry is not flexible)
    vectors = [
        Parameters(rig.model_copy(update={"plant": rig.plant.model_copy(update={"effects": (*others, *order)})})).values
        for order in permutations([flexible, *more])
    ]
    for vector in vectors[1:]:
        np.testing.assert_array_equal(vector, vectors[0])
    assert vectors[0][C.LINK_DAMPING] > 0.02
