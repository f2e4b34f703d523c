"""`longreach ui` as a user starts it, beside a daemon."""

from __future__ import annotations

import http.client
import json
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

TOKEN = "a-token-for-the-tests-0123456789"


@dataclass(frozen=True)
class PageServer:
    """`address` has the token in it."""

    address: str
    port: int
    pid: int

    def send(
        self, method: str, path: str, body: bytes = b"", headers: Mapping[str, str] | None = None
    ) -> tuple[int, Any, Mapping[str, str]]:
        """Status, content (JSON where it is) and headers of an answer; the token goes along unless `headers` say otherwise."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        sent = {"Authorization": f"Bearer {TOKEN}", "Content-Type": "application/json", **(headers or {})}
        connection.request(method, path, body, sent)
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        kind = answer.headers.get("content-type", "")
        return answer.status, json.loads(content) if "json" in kind else content, answer.headers

    def ask(self, method: str, headers: Mapping[str, str] | None = None, **params: Any) -> tuple[int, Any]:
        """A request of the socket through the page."""
        status, content, _ = self.send("POST", "/api/request", json.dumps({"method": method, "params": params}).encode(), headers)
        return status, content


@contextmanager
def page_server(socket: Path, directory: Path, *words: str) -> Iterator[PageServer]:
    """`longreach ui` on a free port. Ended as Ctrl-C would end it."""
    token = directory / "token"
    token.touch(0o600)
    token.write_text(TOKEN)
    command = [sys.executable, "-m", "daemon.cli.main", "--socket", str(socket), "ui", "--port", "0", "--token-file", str(token), *words]
    with (directory / "ui.txt").open("wb") as errors:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True)
    try:
        assert process.stdout is not None
        said = process.stdout.readline()
        address = said.partition(": ")[2].strip()
        assert address, (directory / "ui.txt").read_text()
        yield PageServer(address, int(address.partition("/#")[0].rpartition(":")[2]), process.pid)
    finally:
        process.terminate()
        process.wait(20)
