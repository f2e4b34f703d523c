"""The installer without a machine: what it refuses, what it stages, what an installed copy holds."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest

from config.loading.load import load_rig

CHECKOUT = Path(__file__).resolve().parents[2]
SYSTEM_PYTHON = "/usr/bin/python3"


def script(name: str, *options: str, path: Path | None = None) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PATH": f"{path}:{os.environ['PATH']}" if path else os.environ["PATH"]}
    command = [str(CHECKOUT / "daemon/systemd" / name), *options]
    return subprocess.run(command, capture_output=True, text=True, timeout=200, check=False, env=environment)


def program(path: Path, text: str) -> Path:
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


def test_without_root_it_says_how(tmp_path: Path) -> None:
    program(tmp_path / "id", '[ "$1" = -u ] && echo 1000 || echo somebody')
    answer = script("install.sh", path=tmp_path)
    assert answer.returncode == 1
    assert "you are somebody, not root" in answer.stderr
    assert "sudo make install" in answer.stderr
    assert "DESTDIR" in answer.stderr


def test_a_directory_of_others_is_not_replaced(tmp_path: Path) -> None:
    theirs = tmp_path / "usr/local/lib/theirs"
    theirs.mkdir(parents=True)
    for name in ("install.sh", "uninstall.sh"):
        answer = script(name, "--destdir", str(tmp_path), "--prefix", "/usr/local")
        assert answer.returncode == 1
        assert "is no longreach" in answer.stderr
        assert theirs.is_dir()


@pytest.mark.parametrize("prefix", ["/home/somebody/longreach", "/root/longreach", "longreach", "/longreach", "/opt/long reach"])
def test_prefixes_the_service_cannot_use(tmp_path: Path, prefix: str) -> None:
    answer = script("install.sh", "--destdir", str(tmp_path), "--prefix", prefix)
    assert answer.returncode == 1
    assert prefix in answer.stderr
    assert not list(tmp_path.iterdir())


def test_an_interpreter_in_a_home_directory_is_refused(tmp_path: Path) -> None:
    """The unit has ProtectHome=yes; it would fail only when started."""
    python = program(tmp_path / "python3", 'case "$2" in *base_prefix*) echo /home/somebody/.pyenv ;; esac')
    answer = script("install.sh", "--destdir", str(tmp_path / "stage"), "--python", str(python))
    assert answer.returncode == 1
    assert "/home/somebody/.pyenv" in answer.stderr


def test_an_old_interpreter_is_refused(tmp_path: Path) -> None:
    python = program(tmp_path / "python3", 'case "$1" in --version) echo Python 3.9.2 ;; *) exit 1 ;; esac')
    answer = script("install.sh", "--destdir", str(tmp_path / "stage"), "--python", str(python))
    assert answer.returncode == 1
    assert "Python 3.9.2; 3.11" in answer.stderr


def test_a_place_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    """Below a file nobody, not even root, makes a folder."""
    (tmp_path / "file").write_text("")
    python = program(tmp_path / "python3", 'case "$2" in *base_prefix*) echo /usr ;; esac')
    answer = script("install.sh", "--destdir", str(tmp_path / "file/stage"), "--python", str(python))
    assert answer.returncode == 1
    assert answer.stderr.startswith(f"longreach: {tmp_path}/file/stage/opt/longreach cannot be made: no new folder can be in ")
    assert "--destdir" in answer.stderr
    assert answer.stderr.count("\n") == 1


@pytest.mark.parametrize("options", [["--nonsense"], ["--prefix"]])
def test_wrong_usage(options: list[str]) -> None:
    answer = script("install.sh", *options)
    assert answer.returncode == 2
    assert "usage:" in answer.stderr


def project() -> dict[str, dict[str, object]]:
    return tomllib.loads((CHECKOUT / "pyproject.toml").read_text())


def canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def test_the_lock_names_every_dependency() -> None:
    locked = {canonical(line.split("==")[0]) for line in (CHECKOUT / "requirements.lock").read_text().split()}
    wanted = {canonical(re.split(r"[<>=!~\[ ;]", text)[0]) for text in project()["project"]["dependencies"]}
    assert wanted <= locked, f"missing in requirements.lock: {', '.join(sorted(wanted - locked))}"


def test_the_can_interface_has_the_bit_rate_of_the_shipped_rig() -> None:
    network = (CHECKOUT / "daemon/systemd/network/10-can0.network").read_text()
    rig = load_rig("ornl_testbed_can").rig
    buses = [device.options["bus"] for device in rig.devices.values() if "bus" in device.options]
    assert {(bus["channel"], bus["bitrate"]) for bus in buses} == {("can0", "1 Mbit/s")}
    assert "Name=can0\n" in network
    assert "BitRate=1M\n" in network


def test_no_package_is_left_out_of_an_installed_copy() -> None:
    patterns = project()["tool"]["setuptools"]["packages"]["find"]["include"]
    ours = {path.parent.name for path in CHECKOUT.glob("*/__init__.py")} - {"tests", "benchmarks"}
    assert {name for name in ours if not any(fnmatch(name, pattern) for pattern in patterns)} == set()


@pytest.fixture(scope="module")
def staged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    version = subprocess.run([SYSTEM_PYTHON, "--version"], capture_output=True, text=True, check=False).stdout.split()[-1:]
    if not version or not version[0].startswith(f"{sys.version_info.major}.{sys.version_info.minor}."):
        pytest.skip(f"{SYSTEM_PYTHON} is {version}; the libraries here are for {sys.version.split()[0]}")
    stage = tmp_path_factory.mktemp("stage")
    answer = script("install.sh", "--destdir", str(stage), "--from-venv", sys.prefix)
    assert answer.returncode == 0, answer.stderr
    return stage


@pytest.mark.slow
def test_staged_copy_is_complete_and_runs_from_elsewhere(staged: Path, tmp_path: Path) -> None:
    installed = next(staged.glob("opt/longreach/lib/python3*/site-packages"))
    tracked = subprocess.run(["git", "-C", str(CHECKOUT), "ls-files"], capture_output=True, text=True, check=False).stdout.split()
    patterns = project()["tool"]["setuptools"]["packages"]["find"]["include"]
    ours = [file for file in tracked if "/" in file and any(fnmatch(file.split("/")[0], each) for each in patterns)]
    assert [file for file in ours if (CHECKOUT / file).exists() and not (installed / file).exists()] == []
    line = "import sys; from daemon.cli.main import main; sys.exit(main(['check', 'ornl_testbed']))"
    answer = subprocess.run(
        [staged / "opt/longreach/bin/python", "-I", "-c", line], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert answer.returncode == 0, answer.stderr
    assert str(CHECKOUT) not in answer.stdout


@pytest.mark.slow
def test_an_installed_copy_names_the_commit_it_was_made_from(staged: Path) -> None:
    line = "from daemon.host.host_facts import software; print(software()['software_commit'])"
    answer = subprocess.run([staged / "opt/longreach/bin/python", "-I", "-c", line], capture_output=True, text=True, check=True)
    head = subprocess.run(["git", "-C", str(CHECKOUT), "rev-parse", "HEAD"], capture_output=True, text=True, check=True).stdout
    assert head.startswith(answer.stdout.strip().rstrip("+"))
    assert len(answer.stdout.strip()) >= 7


@pytest.mark.slow
def test_staged_files_know_nothing_of_the_stage(staged: Path) -> None:
    mentions = subprocess.run(["grep", "-rIlF", str(staged), str(staged)], capture_output=True, text=True, check=False).stdout
    assert mentions == ""
    first = (staged / "opt/longreach/bin/longreachd").read_text().splitlines()[0]
    assert first == "#!/opt/longreach/bin/python"


@pytest.mark.slow
def test_another_prefix_reaches_the_unit_and_configuration_is_kept(staged: Path) -> None:
    rig, network = staged / "etc/longreach/rig.yaml", staged / "etc/systemd/network/10-can0.network"
    rig.write_text("ours\n")
    network.write_text("ours\n")
    assert script("install.sh", "--destdir", str(staged), "--prefix", "/srv/arm/longreach", "--from-venv", sys.prefix).returncode == 0
    units = [(staged / "etc/systemd/system" / name).read_text() for name in ("longreachd.service", "longreach-reports.service")]
    assert "/srv/arm/longreach/bin/longreachd" in units[0]
    assert "/srv/arm/longreach/bin/longreach log report" in units[1]
    assert "/opt/longreach" not in "".join(units)
    assert not list((staged / "etc/systemd/system").glob("*.wants")), "nothing is enabled by the installation"
    assert script("uninstall.sh", "--destdir", str(staged), "--prefix", "/srv/arm/longreach").returncode == 0
    assert not (staged / "srv/arm/longreach").exists()
    assert not list((staged / "etc/systemd/system").iterdir())
    assert rig.read_text() == network.read_text() == "ours\n"
