"""The benchmark runs from end to end, and refuses wrong arguments in one line."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent
COMPILED = {name: value for name, value in os.environ.items() if name != "NUMBA_DISABLE_JIT"}


def bench(*arguments):
    command = [sys.executable, "scripts/bench", *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, env=COMPILED, check=False, capture_output=True, text=True)


@pytest.mark.nightly
def test_a_short_run_measures_each_row_or_says_why_not(tmp_path):
    """Without the rows that start processes; the part of the page that is written by hand stays."""
    page, old = tmp_path / "page.md", (ROOT / "docs" / "explanation" / "performance.md").read_text()
    page.write_text(old)
    rows = ("peers", "batch", "threads", "hunters", "targets", "one-arena", "learners", "resets", "memory")
    done = bench("--rounds", 1, "--seconds", 0.01, "--only", *rows, "--json", tmp_path / "bench.json", "--page", page)
    assert done.returncode == 0, done.stderr
    figures, new = json.loads((tmp_path / "bench.json").read_text()), page.read_text()
    assert new.startswith(old.partition("<!-- made by make bench -->")[0])
    for name in figures["versions"]["peers"]:
        assert f"\n| {name} " in new
    for name, reason in figures["skipped"].items():
        assert f"Skipped: {name} ({reason})." in new
    for name in ("4 hunters", "batch of 1,024", "one arena, full control", "LearnerBatch, patrol"):
        assert re.search(rf"^\| {name} +\|.* [\d.,]+ \|$", new, re.MULTILINE), name
    assert re.search(r"^\| memory +\|.* bytes per arena ", new, re.MULTILINE)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--only", "everything"), "invalid choice: 'everything'"),
        (("--against", "HEAD", "--only", "peers"), "--against measures no peers"),
        (
            ("--against", "HEAD", "--page", "docs/explanation/performance.md"),
            "--against measures no peers and writes no page",
        ),
        (("--rounds", 0), "--rounds must be at least 1"),
        (("--page", "README.md"), "--page must be a page that has the marks"),
        (("--page", "no.md"), "got no.md"),
    ],
)
def test_bad_arguments_are_one_line(arguments, message):
    """Before anything is measured."""
    done = bench(*arguments)

    assert done.returncode == 2
    assert message in done.stderr.splitlines()[-1]
