"""Places of objects as a user writes them, their values as the canopen package decodes them, and the statistics as numpy has them."""

from __future__ import annotations

from pathlib import Path

import canopen
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import config
from config.errors import ConfigError
from config.options.canopen_options import EncoderOptions, IoOptions, ValveOptions
from config.options.device_options import RigNames
from drivers.inspection.objects import EDS, NodeObject, of_channel, of_eds, of_word
from drivers.inspection.statistics import Statistics

BUS = {"interface": "virtual", "channel": "objects"}


@pytest.mark.parametrize(
    ("word", "place", "kind"),
    [("6004", "0x6004:0", ""), ("0x6401:2", "0x6401:2", ""), ("1018:4/u32", "0x1018:4", "u32"), ("1008/text", "0x1008:0", "text")],
)
def test_words_name_objects(word: str, place: str, kind: str) -> None:
    found = of_word(word, {})
    assert (found.place, found.type) == (place, kind)


@pytest.mark.parametrize("word", ["", "6004:", "60041", "6004:256", "6004/u7", "node", "6004:1:2"])
def test_other_words_are_refused(word: str) -> None:
    with pytest.raises(ConfigError, match="not an object"):
        of_word(word, {})


@pytest.mark.parametrize("profile", sorted(EDS))
@given(content=st.binary(min_size=1, max_size=8))
def test_values_are_those_of_the_canopen_package(profile: int, content: bytes) -> None:
    dictionary = canopen.import_od(str(Path(config.__file__).parent / "eds" / EDS[profile]), 5)
    for (index, sub), found in of_eds(None, profile, 5).items():
        entry = dictionary[index] if sub == 0 and not hasattr(dictionary[index], "values") else dictionary[index][sub]
        size = len(entry) // 8
        if len(content) >= size:
            assert found.value(content[:size]) == entry.decode_raw(content[:size]), found


def test_channels_are_the_objects_that_the_drivers_map() -> None:
    """Against the dictionary: the mapped objects exist there with this type."""
    valve = ValveOptions(bus=BUS, node=1, fault_reactions={1: 2})
    devices = {406: EncoderOptions(bus=BUS, node=1), 408: valve, 401: IoOptions(bus=BUS, node=1)}
    seen = 0
    for profile, options in devices.items():
        listed = of_eds(None, profile, 1)
        for channels in (options.input_channels(RigNames()), options.output_channels(RigNames())):
            for name, channel in channels.items():
                found = of_channel(name, channel)
                assert listed[found.index, found.sub].type == found.type, name
                seen += 1
    assert seen == 2 + 3 + 8


def test_bytes_that_are_no_number_are_shown() -> None:
    assert NodeObject(0x2000, 0).value(b"\x01\x02\x03") == "01 02 03"
    assert NodeObject(0x1008, 0, type="text").value(b"AC58\0\0") == "AC58"
    assert NodeObject(0x6004, 0, type="u32").value(b"\x01") == "01"


@given(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=50))
def test_statistics_are_those_of_numpy(values: list[float]) -> None:
    kept = Statistics()
    for value in values:
        kept.take(value)
    assert (kept.count, kept.least, kept.greatest) == (len(values), min(values), max(values))
    np.testing.assert_allclose([kept.mean, kept.sd], [np.mean(values), np.std(values, ddof=1)], rtol=1e-6, atol=1e-6)
