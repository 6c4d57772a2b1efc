"""The README's code runs, and the pages that are made from code are up to date."""

import re
import runpy
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent
README = (ROOT / "README.md").read_text()


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


@pytest.mark.large
@pytest.mark.parametrize("code", blocks("python"))
def test_the_readmes_python_runs(code, tmp_path):
    """As it stands, in a process of its own."""
    subprocess.run([sys.executable, "-c", code], check=True, cwd=tmp_path)


def test_the_readmes_commands_run(tmp_path):
    """Every line that calls catch-arena, one after the other, in an empty folder; `make` is what runs this."""
    lines = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("catch-arena")]
    assert lines
    program = shutil.which("catch-arena", path=str(Path(sys.executable).parent))
    for line in lines:
        _, *arguments = shlex.split(line, comments=True)
        subprocess.run([program, *arguments], check=True, cwd=tmp_path, stdout=subprocess.DEVNULL)


def test_the_readme_begins_with_its_two_commands():
    """That is `make demo`, then `make test`."""
    commands = [line.split("#")[0].strip() for block in blocks("sh") for line in block.splitlines() if line.strip()]

    assert commands[:2] == ["make demo", "make test"]


def test_the_made_pages_are_up_to_date():
    """`make docs` would change nothing."""
    write_docs = runpy.run_path(str(ROOT / "scripts" / "write_docs.py"))

    assert (ROOT / "docs" / "observation.md").read_text() == write_docs["observation_page"]()
