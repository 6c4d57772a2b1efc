"""`make setup` on a machine that lacks something prints what to install, and leaves nothing half made."""

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def set_up(tmp_path):
    """Run `make setup` in a folder of its own with a stand-in for Python, and return what it printed."""
    shutil.copy(ROOT / "Makefile", tmp_path)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    python = tmp_path / "python"

    def run(script):
        python.write_text(f"#!/bin/sh\n{script}\n")
        python.chmod(0o755)
        words = ["make", "--silent", "--no-print-directory", "setup", f"PYTHON={python}"]
        ended = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert ended.returncode == 2
        return ended.stdout

    return run


def test_a_python_that_is_too_old_is_named_with_a_way_out(set_up, tmp_path):
    assert set_up("exit 1") == "Catch Arena needs Python 3.10 to 3.13; name one: make PYTHON=python3.11 setup\n"
    assert not (tmp_path / ".venv").exists()


def test_a_python_without_venv_names_the_package_and_leaves_no_environment(set_up, tmp_path):
    printed = set_up('test "$1" = -c && exit; mkdir -p .venv/bin; echo "no ensurepip"; exit 1')
    assert printed == "cannot make .venv; on Debian and Ubuntu: apt-get install python3-venv\n"
    assert not (tmp_path / ".venv").exists()


def test_an_environment_that_works_is_never_made_again(set_up, tmp_path):
    """Also one that `make` did not make: its packages stay, whatever fails later."""
    own = tmp_path / ".venv" / "bin"
    own.mkdir(parents=True)
    (own / "python").write_text("#!/bin/sh\nexit 1\n")
    (own / "python").chmod(0o755)
    set_up("exit 0")
    assert (own / "python").exists()
