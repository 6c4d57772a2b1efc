"""`make`: nothing half made stays, and every target has a recipe."""

import re
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def set_up(tmp_path):
    """Run `make setup` in a folder of its own with a stand-in for Python, which fails."""
    shutil.copy(ROOT / "Makefile", tmp_path)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    python = tmp_path / "python"

    def run(script):
        python.write_text(f"#!/bin/sh\n{script}\n")
        python.chmod(0o755)
        words = ["make", "--silent", "--no-print-directory", "setup", f"PYTHON={python}"]
        assert subprocess.run(words, cwd=tmp_path, capture_output=True, check=False).returncode == 2

    return run


def test_a_python_without_venv_leaves_no_environment(set_up, tmp_path):
    set_up('mkdir -p .venv/bin; echo "no ensurepip"; exit 1')
    assert not (tmp_path / ".venv").exists()


def test_an_environment_that_works_is_never_made_again(set_up, tmp_path):
    """Also one that `make` did not make: its packages stay, whatever fails later."""
    own = tmp_path / ".venv" / "bin"
    own.mkdir(parents=True)
    (own / "python").write_text("#!/bin/sh\nexit 1\n")
    (own / "python").chmod(0o755)
    set_up("exit 0")
    assert (own / "python").exists()


def test_every_target_has_one_recipe():
    """A name in .PHONY without a rule succeeds and does nothing; of two rules with one name the first is ignored."""
    text = (ROOT / "Makefile").read_text()
    rules = Counter(re.findall(r"^([a-z]+):", text, re.MULTILINE))
    phony = re.search(r"^\.PHONY: ((?:.*\\\n)*.*)$", text, re.MULTILINE)[1].replace("\\", "").split()
    assert rules == Counter(phony)
