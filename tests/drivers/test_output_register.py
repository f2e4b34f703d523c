from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from config.errors import DriverError
from drivers.output_register import OutputRegister

MS = 1_000_000


def test_the_law_of_the_time_out(tmp_path: Path) -> None:
    register = OutputRegister.create([0.0, -0.5], 0.1, tmp_path / "r")
    assert register.effective(0) == (0.0, -0.5), "nothing written yet"
    register.write([3.0, 4.0], 1000 * MS)
    assert register.effective(1100 * MS) == (3.0, 4.0)
    assert register.effective(1100 * MS + 1) == (0.0, -0.5)
    register.make_safe()
    assert register.effective(1000 * MS) == (0.0, -0.5)


def test_another_process_sees_the_same(tmp_path: Path) -> None:
    writer = OutputRegister.create([0.0], 0.1, tmp_path / "r")
    reader = OutputRegister.attach(tmp_path / "r")
    for number in range(1, 50):
        writer.write([float(number)], number * MS)
        assert reader.last_write() == ((float(number),), number * MS)
        assert reader.sequence == number


def test_a_new_register_does_not_disturb_a_reader_of_the_old(tmp_path: Path) -> None:
    old = OutputRegister.create([0.0], 0.1, tmp_path / "r")
    old.write([2.0], 5 * MS)
    reader = OutputRegister.attach(tmp_path / "r")
    OutputRegister.create([0.0, 0.0], 0.1, tmp_path / "r")
    assert reader.last_write() == ((2.0,), 5 * MS)


def test_a_kill_between_two_stores_leaves_a_whole_write(tmp_path: Path) -> None:
    """The writer writes equal values in every valve; after any kill all valves of the valid slot agree with its stamp."""
    path = tmp_path / "r"
    script = (
        "from drivers.output_register import OutputRegister; from pathlib import Path; import sys\n"
        "r = OutputRegister.create([0.0] * 6, 0.1, Path(sys.argv[1])); print('on', flush=True); n = 0\n"
        "while True:\n    n += 1\n    r.write([float(n)] * 6, n)\n"
    )
    for _ in range(8):
        with subprocess.Popen([sys.executable, "-c", script, str(path)], stdout=subprocess.PIPE) as process:
            assert process.stdout is not None
            process.stdout.readline()
            reader = OutputRegister.attach(path)
            while reader.sequence < 1000:
                os.sched_yield()
            process.send_signal(signal.SIGKILL)
            process.wait()
        values, stamp = reader.last_write()
        assert set(values) == {float(stamp)}


def test_what_is_no_register_is_refused(tmp_path: Path) -> None:
    (tmp_path / "empty").write_bytes(b"")
    (tmp_path / "other").write_bytes(bytes(200))
    for name in ("empty", "other", "missing"):
        with pytest.raises(DriverError, match="register"):
            OutputRegister.attach(tmp_path / name)
    with pytest.raises(DriverError, match="cannot be made"):
        OutputRegister.create([0.0], 0.1, tmp_path / "no" / "directory")
