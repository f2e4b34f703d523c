"""A daemon, and the page's server beside it: one that only looks, one that may drive."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.support.daemon.running_daemon import RunningDaemon
from tests.support.live.gentle_daemon import gentle_daemon
from tests.support.live.page_server import PageServer, page_server


@pytest.fixture(scope="module")
def daemon(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningDaemon]:
    with gentle_daemon(tmp_path_factory.mktemp("daemon")) as running:
        yield running


@pytest.fixture(scope="module")
def looking(daemon: RunningDaemon, tmp_path_factory: pytest.TempPathFactory) -> Iterator[PageServer]:
    with page_server(daemon.socket, tmp_path_factory.mktemp("looking")) as served:
        yield served


@pytest.fixture(scope="module")
def driving(daemon: RunningDaemon, tmp_path_factory: pytest.TempPathFactory) -> Iterator[PageServer]:
    with page_server(daemon.socket, tmp_path_factory.mktemp("driving"), "--control") as served:
        yield served
