"""Set-up where something is missing: each failure says what to do, leaves nothing half made, and can be tried again."""

import ensurepip
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SET_UP = ROOT / "scripts" / "set_up.py"
PYTHON = Path(sys.base_prefix) / "bin" / "python3"
WHEELS = Path(ensurepip.__file__).parent / "_bundled"
"""pip's own wheel, which Python carries: an index of one package."""

ABSENT = """
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name in {modules!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Absent())
"""


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A folder with a project that needs a package which is nowhere."""
    (tmp_path / "pyproject.toml").write_text(
        '[project]\nname = "little"\nversion = "1"\ndependencies = ["numpy>=9999"]\n'
        '[dependency-groups]\nself = ["pip"]\nnone = ["there-is-no-such-package"]\n'
    )
    monkeypatch.chdir(tmp_path)
    for name in [name for name in os.environ if name.startswith("PIP_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("PIP_CONFIG_FILE", os.devnull)
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(WHEELS))
    return tmp_path


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """One that was made before."""
    folder = tmp_path_factory.mktemp("made") / ".venv"
    subprocess.run([PYTHON, "-m", "venv", folder], check=True)
    return folder


def python_without(folder, *modules):
    """A Python that lacks some modules of its library, as Debian's does before python3-venv is installed."""
    (folder / "absent").mkdir()
    (folder / "absent" / "sitecustomize.py").write_text(ABSENT.format(modules=modules))
    stub = folder / "python-without"
    stub.write_text(f'#!/bin/sh\nPYTHONPATH={folder}/absent exec {PYTHON} "$@"\n')
    stub.chmod(0o755)
    return stub


def set_up(*words, python=PYTHON, environment=".venv"):
    return subprocess.run([python, SET_UP, environment, *words], capture_output=True, text=True, check=False)


def has_pip(environment):
    asked = subprocess.run([environment / "bin/python", "-m", "pip", "--version"], capture_output=True, check=False)
    return asked.returncode == 0


def test_a_debian_without_python3_venv_says_so_leaves_nothing_and_goes_on_when_it_is_there(project):
    stub = python_without(project, "ensurepip", "pip")
    for _ in range(2):  # the second run finds what the first one left: nothing
        failed = set_up("--group", "self", python=stub)
        assert failed.returncode == 1
        assert "cannot make a virtual environment: it lacks ensurepip" in failed.stderr
        assert "apt-get install python3-venv" in failed.stderr
        assert "Traceback" not in failed.stderr + failed.stdout
        assert not (project / ".venv").exists()
    assert set_up("--group", "self").returncode == 0  # python3-venv has been installed
    assert has_pip(project / ".venv")


def test_make_says_so_too_where_python_has_neither_venv_nor_pip(project):
    stub = python_without(project, "venv", "ensurepip", "pip")
    environment = project / "env"
    failed = subprocess.run(
        ["make", "-C", ROOT, "demo", f"PYTHON={stub}", f"VENV={environment}"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert failed.returncode == 2
    assert "apt-get install python3-venv" in failed.stderr
    assert not environment.exists()


def test_where_python_has_a_pip_but_no_ensurepip_that_pip_fills_the_environment(project):
    done = set_up("--group", "self", python=python_without(project, "ensurepip"))
    assert done.returncode == 0, done.stderr
    assert has_pip(project / ".venv")


@pytest.mark.parametrize("left", ["an environment without pip", "a python that is gone"])
def test_what_was_half_made_is_made_anew(project, left):
    environment = project / ".venv"
    (environment / "bin").mkdir(parents=True)
    gone = PYTHON if left == "an environment without pip" else project / "nowhere"
    (environment / "bin" / "python").symlink_to(gone)
    (environment / "pyvenv.cfg").write_text(f"home = {PYTHON.parent}\ninclude-system-site-packages = false\n")
    done = set_up("--group", "self")
    assert "made anew" in done.stdout
    assert done.returncode == 0, done.stderr
    assert has_pip(environment)


@pytest.mark.usefixtures("project")
def test_a_package_that_cannot_be_had_is_named_and_the_environment_stays(environment):
    failed = set_up("--group", "none", environment=environment)
    assert failed.returncode == 1
    assert "what `none` needs could not be installed" in failed.stderr
    assert "there-is-no-such-package" in failed.stderr
    assert "set_up.log" in failed.stderr
    again = set_up("--group", "self", environment=environment)
    assert again.returncode == 0, again.stderr
    assert "making" not in again.stdout


@pytest.mark.usefixtures("project")
def test_without_a_network_it_is_said_that_there_is_none(environment, monkeypatch):
    monkeypatch.delenv("PIP_NO_INDEX")
    with socket.socket() as nobody:
        nobody.bind(("127.0.0.1", 0))  # a port at which nobody listens
        monkeypatch.setenv("PIP_INDEX_URL", f"http://127.0.0.1:{nobody.getsockname()[1]}/simple")
        monkeypatch.setenv("PIP_RETRIES", "0")
        failed = set_up("--group", "none", environment=environment)
    assert failed.returncode == 1
    assert "the package index cannot be reached" in failed.stderr
    assert "goes on from here" in failed.stderr


@pytest.mark.usefixtures("project")
def test_ctrl_c_in_the_middle_of_pip_ends_with_one_line_and_pip_with_it(environment, monkeypatch):
    monkeypatch.delenv("PIP_NO_INDEX")
    with socket.create_server(("127.0.0.1", 0)) as silent:  # an index that takes a question, and never answers
        monkeypatch.setenv("PIP_INDEX_URL", f"http://127.0.0.1:{silent.getsockname()[1]}/simple")
        begun = subprocess.Popen(
            [PYTHON, SET_UP, environment, "--group", "none"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        asked, _ = silent.accept()
        with asked:
            os.killpg(begun.pid, signal.SIGINT)
            _, said = begun.communicate(timeout=30)
    assert begun.returncode == 130
    assert said.splitlines() == ["interrupted; the same command goes on from here"]
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline and living(begun.pid):
        time.sleep(0.05)
    assert not living(begun.pid)


def living(group):
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def test_what_pip_says_of_a_full_disk_becomes_the_folder_and_the_space_that_is_left(tmp_path):
    sys.path.insert(0, str(SET_UP.parent))
    try:
        from set_up import LOG, failure
    finally:
        sys.path.remove(str(SET_UP.parent))
    (tmp_path / LOG).write_text(
        "ERROR: Could not install packages due to an OSError: [Errno 28] No space left on device\n"
    )
    told = failure(tmp_path, "it")
    free = shutil.disk_usage(tmp_path).free / 1e6
    assert "the disk is full" in told
    assert f"{tmp_path} has " in told
    assert abs(float(told.split(" has ")[1].split()[0]) - free) < 1000
