"""The driver printed in docs/guide/rig/write-a-driver.md works: it reads a gauge on a socket, and says by its age that nothing new came."""

from __future__ import annotations

import socket
import time
from types import SimpleNamespace
from typing import Any

from tests.docs.pages import DOCS, blocks


def page_module() -> dict[str, Any]:
    code = next(block for block in blocks(DOCS / "guide" / "rig" / "write-a-driver.md") if block.words == ("python",))
    module: dict[str, Any] = {}
    exec("\n".join(code.lines), module)
    return module


def test_the_printed_driver_reads_its_gauge() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        device = SimpleNamespace(options={"host": "127.0.0.1", "port": server.getsockname()[1]})
        driver = page_module()["create"]("gauge", device, None, False)
        driver.open()
        gauge, _ = server.accept()
        driver.configure()
        driver.activate()
        assert driver.read(time.monotonic_ns())[0].quality == 2, "nothing was measured yet"
        gauge.sendall(b"PRESSURE 1234\n")
        deadline = time.monotonic() + 10.0
        while driver.read(time.monotonic_ns())[0].quality != 0:
            assert time.monotonic() < deadline
        sample = driver.read(time.monotonic_ns())[0]
        assert (sample.raw, sample.quality) == (1234.0, 0)
        before = sample.stamp_ns
        assert driver.read(time.monotonic_ns())[0].stamp_ns == before, "no news, no new stamp"
        driver.safe()
        driver.close()
        gauge.close()
