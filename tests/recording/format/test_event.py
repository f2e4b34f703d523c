"""Events: exact round trip, and nonsense refused."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from config.errors import LogError
from recording.format.event import EVENT_SCHEMA, EVENT_SCHEMA_TEXT, Event, decode_event, encode_event

_floats = st.floats(allow_nan=False)
_events = st.builds(
    Event,
    cycle=st.integers(0, 2**64 - 1),
    t_s=_floats,
    level=st.integers(0, 255),
    name=st.text(max_size=20),
    text=st.text(max_size=60),
    values=st.dictionaries(st.text(max_size=12), _floats, max_size=5),
)


@given(_events)
def test_round_trip_is_exact(event: Event) -> None:
    again = decode_event(encode_event(event))
    assert again == event
    assert list(again.values) == list(event.values)


@given(_events)
def test_rosbags_encodes_the_same_bytes(event: Event) -> None:
    import numpy as np

    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(EVENT_SCHEMA_TEXT, EVENT_SCHEMA))
    message = store.types[EVENT_SCHEMA](
        cycle=event.cycle,
        t_s=event.t_s,
        level=event.level,
        name=event.name,
        text=event.text,
        value_names=list(event.values),
        values=np.array(list(event.values.values()), dtype=np.float64),
    )
    theirs = bytes(store.serialize_cdr(message, EVENT_SCHEMA))
    ours = encode_event(event)
    assert theirs[: len(ours)] == ours
    assert set(theirs[len(ours) :]) <= {0}  # rosbags aligns before an empty sequence, which holds nothing


@given(_events, st.data())
def test_a_cut_event_is_refused_not_guessed(event: Event, data: st.DataObject) -> None:
    whole = encode_event(event)
    cut = whole[: data.draw(st.integers(0, len(whole) - 1))]
    with pytest.raises(LogError, match="an event of the log cannot be read"):
        decode_event(cut)


@given(st.binary(max_size=80))
def test_random_bytes_raise_nothing_but_log_errors(data: bytes) -> None:
    try:
        decode_event(data)
    except LogError:
        return


def test_a_number_that_does_not_fit_is_refused() -> None:
    with pytest.raises(LogError, match="an event cannot be stored"):
        encode_event(Event(-1, 0.0, 20, "x", "y"))


def test_the_first_bytes_are_plain_little_endian_cdr() -> None:
    data = encode_event(Event(7, 0.5, 30, "a", "b", {"x_m": 1.0}))
    assert data[:4] == b"\x00\x01\x00\x00"
    assert struct.unpack_from("<QdB", data, 4) == (7, 0.5, 30)
