"""A bare `longreach estop`: the request leaves before parsers and the other commands' libraries are loaded.

On a computer whose processors are busy, loading them took longer than all else on the way to safe outputs. With other options, or where
the daemon's answer is not the expected one, the usual command asks (again) and says what is wrong.
"""

from __future__ import annotations

import socket

from daemon.processes.paths import socket_path

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence

OUTPUTS_SAFE = "e-stop: outputs are safe; `longreach reset` clears it"
_REQUEST = b'{"v":1,"id":1,"method":"estop","params":{}}\n'
_DONE = b'{"id":1,"result":'
_PATIENCE_S = 2.0


def estop_at_once(words: Sequence[str]) -> bool:
    """Whether these words are a bare `estop` (with `--socket` before it or not) and the daemon has answered that it is done."""
    match words:
        case ["estop"]:
            chosen = None
        case ["--socket", chosen, "estop"]:
            pass
        case _:
            return False
    if not _answer(str(socket_path(chosen))).startswith(_DONE):
        return False
    print(OUTPUTS_SAFE)
    return True


def _answer(path: str) -> bytes:
    """As much of the daemon's answer as comes in one piece; empty where none comes."""
    try:
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as daemon:
            daemon.settimeout(_PATIENCE_S)
            daemon.connect(path)
            daemon.sendall(_REQUEST)
            return daemon.recv(4096)
    except OSError:
        return b""
