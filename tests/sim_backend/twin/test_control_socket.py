"""The place of the twin's control socket: a file there, or another twin's socket, is not touched."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest

from config.errors import PlantError
from sim_backend.twin.control_socket import ControlSocket


def test_a_file_is_not_taken_for_a_socket(tmp_path: Path) -> None:
    notes = tmp_path / "notes.txt"
    notes.write_text("precious")
    with pytest.raises(PlantError, match="taken by a file"):
        ControlSocket(notes)
    assert notes.read_text() == "precious"


def test_the_socket_of_a_running_twin_stays_its_own(tmp_path: Path) -> None:
    place = tmp_path / "twin.sock"
    with closing(ControlSocket(place)):
        inode = place.stat().st_ino
        with pytest.raises(PlantError, match="another twin has this control socket"):
            ControlSocket(place)
        assert place.stat().st_ino == inode
    assert not place.exists()


def test_the_socket_of_a_twin_that_was_killed_makes_room(tmp_path: Path) -> None:
    place = tmp_path / "twin.sock"
    killed = ControlSocket(place)
    killed._socket.close()
    assert place.is_socket()
    with closing(ControlSocket(place)):
        assert place.is_socket()


def test_a_socket_that_took_ones_place_is_left_at_the_end(tmp_path: Path) -> None:
    place = tmp_path / "twin.sock"
    first = ControlSocket(place)
    place.unlink()
    with closing(ControlSocket(place)):
        first.close()
        assert place.is_socket()
