"""Every command and every Python block of README and docs runs, and every link leads somewhere.

A block that cannot run here has a comment with the reason above it: `<!-- not run: REASON -->`; one that takes long has
`<!-- nightly -->`, and one that needs a module `<!-- needs MODULE -->`. Blocks of Python with a file's name (`python
file=mine.py`) are saved under it. The blocks of a page run one after the other in a scratch folder that has a recorded
match and a small tournament. Videos and tournaments are made smaller than on the page.
"""

import importlib.util
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest
from typer.testing import CliRunner

from catch_arena.cli import main

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(
    r"(?:^<!-- (?P<mark>nightly|needs \w+|not run: [^\n]+?) -->\n+)?"
    r"^```(?P<kind>\w*)(?: file=(?P<file>\S+))?\n(?P<text>.*?)^```",
    re.MULTILINE | re.DOTALL,
)
SMALLER = {
    "tournament": ("--set", "time_limit_s=8", "--rounds", "1"),
    "compare": ("--set", "time_limit_s=8", "--max-blocks", "2"),
    "suite": ("--quick",),
    # one submission of the sample class hangs
    "league": ("--set", "time_limit_s=8", "--max-matches", "4", "--limit", "step_ms=60", "--limit", "bank_s=1"),
    "grade": ("--limit", "step_ms=60", "--limit", "bank_s=0.2"),
    "render": ("--size", "320x320", "--fps", "2"),
    "highlights": ("--size", "320x320", "--fps", "2"),
    "ros serve": ("--set", "time_limit_s=5"),
}
"""Options that make a command cheap; they come last, so that they win."""
ANSWERS_NO = {"compare": (0, 1, 3), "diff": (0, 1), "grade": (0, 1), "check-agent": (0, 1), "conformance": (0, 1)}
"""Exit codes of commands whose answer may be no (docs/reference/command_line.md)."""


AGENT = "class Agent:\n    def reset(self, seed): pass\n    def act(self, view): return 1 if view.targets else 0\n"


class Block(NamedTuple):
    mark: str
    kind: str
    file: str
    text: str


def blocks_of(page):
    return [Block(*(one.group(name) or "" for name in Block._fields)) for one in BLOCK.finditer(page.read_text())]


def commands(text):
    """Return the command lines of a block, without comments; a backslash continues a line."""
    lines = text.replace("\\\n", " ").splitlines()
    return [words for line in lines if (words := shlex.split(line, comments=True))]


def run_command(words, background):
    """Run a command line; one that ends in `&` runs until the page ends."""
    program, *arguments = words
    if program == "export":
        os.environ.update(one.split("=", 1) for one in arguments)
        return
    if program == "kill":
        return
    if program == "make":
        assert re.search(rf"^{arguments[-1]}:", (ROOT / "Makefile").read_text(), re.MULTILINE)
        return
    assert program == "catch-arena", f"tag this block as not run, with a reason: {' '.join(words)}"
    if arguments[-1] == "&":
        background.append(subprocess.Popen([sys.executable, "-m", "catch_arena", *arguments[:-1]]))
        return
    smaller = SMALLER.get(" ".join(arguments[:2])) or SMALLER.get(arguments[0], ())
    if "--shape" in arguments:  # it decides the size
        smaller = ("--fps", "1")
    done = CliRunner().invoke(main, [*arguments, *smaller])
    assert done.exit_code in ANSWERS_NO.get(arguments[0], (0,)), (words, done.output)


def run_page(page, *, nightly):
    """Run the blocks of a page; those of the night only if `nightly`."""
    blocks = blocks_of(page)
    for block in reversed(blocks):
        if block.file:
            Path(block.file).write_text(block.text)
    background = []
    try:
        run_blocks(page, blocks, background, nightly=nightly)
    finally:
        for process in background:
            process.terminate()
            process.wait()


def left_out(mark, *, nightly):
    kind, _, rest = mark.partition(" ")
    if kind == "needs":
        return importlib.util.find_spec(rest) is None
    return kind == "not" or (kind == "nightly" and not nightly)


def run_blocks(page, blocks, background, *, nightly):
    for block in blocks:
        if block.file:
            Path(block.file).write_text(block.text)
        elif left_out(block.mark, nightly=nightly):
            continue
        elif block.kind == "python":
            exec(compile(block.text, page.name, "exec"), {"__name__": "__main__"})  # noqa: S102 - ours
        elif block.kind == "sh":
            for words in commands(block.text):
                run_command(words, background)


@pytest.fixture(scope="session")
def recorded(tmp_path_factory):
    """A folder with three agents, match.replay, and recorded/, a small tournament."""
    folder = tmp_path_factory.mktemp("recorded")
    for file in ("mine.py", "ann/agent.py", "bob/agent.py", "class/ann/agent.py", "class/bob/agent.py"):
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(AGENT)
    (folder / "hidden_seed.txt").write_text("c0ffee00" * 4)
    for words in (
        ("match", "nearest", "contested", "patrol", "first", "--seed", "3", "-o", folder / "match.replay"),
        (
            *("tournament", "nearest", "contested", "first", "random", "--rounds", "1", "--record", "--seed", "1"),
            *("--set", "time_limit_s=8", "--out", folder / "recorded"),
        ),
    ):
        done = CliRunner().invoke(main, [str(word) for word in words])
        assert done.exit_code == 0, done.output
    return folder


@pytest.fixture
def scratch(recorded, tmp_path, monkeypatch):
    shutil.copytree(recorded, tmp_path, dirs_exist_ok=True)
    for name in ("ROS_LOCALHOST_ONLY", "ROS_DOMAIN_ID"):  # pages set them; the test's end sets them back
        monkeypatch.setenv(name, "")
    monkeypatch.chdir(tmp_path)


def names(pages):
    return [page.relative_to(ROOT).as_posix() for page in pages]


WITH_BLOCKS = [page for page in PAGES if any(block.kind in {"sh", "python"} for block in blocks_of(page))]
LONG = [page for page in PAGES if any(block.mark == "nightly" for block in blocks_of(page))]


@pytest.mark.large
@pytest.mark.usefixtures("scratch")
@pytest.mark.parametrize("page", WITH_BLOCKS, ids=names(WITH_BLOCKS))
def test_the_blocks_of_a_page_run(page):
    run_page(page, nightly=False)


@pytest.mark.nightly
@pytest.mark.usefixtures("scratch")
@pytest.mark.parametrize("page", LONG, ids=names(LONG))
def test_the_long_blocks_of_a_page_run(page):
    run_page(page, nightly=True)


def test_few_blocks_are_not_run():
    """Each names its reason. Run a new block if it can run, and change this number if it cannot."""
    marks = [block.mark for page in PAGES for block in blocks_of(page) if block.mark.startswith("not run")]
    assert len(marks) == 51, marks


@pytest.mark.parametrize("page", PAGES, ids=names(PAGES))
def test_code_is_as_wide_as_a_page_of_the_site(page):
    """At 1280 pixels; longer lines are cut."""
    assert not [line for block in blocks_of(page) for line in block.text.splitlines() if len(line) > 90]


@pytest.mark.parametrize("page", PAGES, ids=names(PAGES))
def test_links_lead_to_files_that_exist(page):
    """Sphinx checks the anchors (`make site`)."""
    targets = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text())
    assert not [x for x in targets if not x.startswith("http") and not (page.parent / x).exists()]
