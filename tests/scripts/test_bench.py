"""The benchmark runs from end to end; what it measures is not tested."""

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


def table(text, heading, words=""):
    """The rows of the first table after a heading, and after these words, without the line under the head."""
    found = re.search(rf"### {heading}\n.*?{words}.*?((?:^\|[^\n]*\n)+)", text, re.DOTALL | re.MULTILINE)
    head, _, *rows = found[1].splitlines()
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in (head, *rows)]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """One quick run: the folder that it wrote into. The phases, for which the step is compiled anew, have their own."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "page.md").write_bytes((ROOT / "docs" / "performance.md").read_bytes())
    done = bench(
        "--quick", "--only", "start", "peers", "ours", "--json", folder / "bench.json", "--page", folder / "page.md"
    )
    assert done.returncode == 0, done.stderr
    return folder


def test_every_peer_is_measured_or_named_as_skipped(run):
    """In the page and in the JSON, whatever is installed here."""
    figures = json.loads((run / "bench.json").read_text())
    page = (run / "page.md").read_text()
    measured = {one["name"] for one in figures["subjects"] if one["group"] == "peers"}

    assert len(measured | figures["skipped"].keys()) == 7
    assert measured.isdisjoint(figures["skipped"])
    for name in measured:
        assert name in [row[0].partition(",")[0] for row in table(page, "Beside others")]
        assert name in [row[0].partition(",")[0] for row in table(page, "Beside others", "How many times")]
    for name, reason in figures["skipped"].items():
        assert f"Skipped: {name} ({reason})." in page


def test_the_tables_are_complete(run):
    """Every control, batch, number of threads, of hunters and of targets; and every row as wide as its head."""
    page = (run / "page.md").read_text()
    doors = {tuple(row[:3]) for row in table(page, "One arena, and batches")[1:]}

    for door in ("target control", "target control, masks read", "velocity control", "full control"):
        assert (f"Catch Arena, one arena, {door}", "1", "1") in doors
    assert {("Catch Arena, batch, target control", "33", threads) for threads in "12"} <= doors
    assert [row[0].split()[0] for row in table(page, "More hunters")[1:]] == ["2", "4", "8", "16", "32", "64"]
    assert [row[0].split()[2] for row in table(page, "More targets")[1:]] == ["4", "8", "16", "32", "64"]
    for heading in ("Beside others", "One arena, and batches", "Reset and memory", "Import and start-up"):
        assert len({len(row) for row in table(page, heading)}) == 1


@pytest.mark.nightly
def test_the_phases_of_a_step_add_up_to_the_whole(tmp_path):
    """As far as rounding goes; the rest has a row of its own, and what only moves memory stands below."""
    done = bench("--quick", "--only", "phases", "--json", tmp_path / "bench.json")
    assert done.returncode == 0, done.stderr
    rows = [row[0] for row in table(done.stdout, "Where a step's time goes")]
    for batch in json.loads((tmp_path / "bench.json").read_text())["phases"]:
        *phases, whole, _, _ = batch["ns_per_agent_step"]
        assert whole == "the whole step"
        assert {*phases, whole} <= {*rows}
        spent = batch["ns_per_agent_step"]
        assert sum(spent[name] for name in phases) == pytest.approx(spent[whole])


def test_the_work_of_a_step_stands_beside_its_rate(run):
    """Ours as the scenario has it."""
    ours = json.loads((run / "bench.json").read_text())["subjects"][0]

    assert (ours["agents"], ours["physics_ticks"], ours["arbiter"]) == (4, "6.25", True)
    assert ours["env_steps_per_cpu_s"] > 0


def test_the_page_keeps_what_is_written_by_hand(run):
    """Only what stands between the marks changes."""
    old = (ROOT / "docs" / "performance.md").read_text()

    assert (run / "page.md").read_text().startswith(old.partition("<!-- made by make bench -->")[0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--only", "everything"), "invalid choice: 'everything'"),
        (("--rounds", 0), "--rounds must be at least 1"),
        (("--json", "no/such/folder.json"), "no/such must be a folder"),
        (("--page", "README.md"), "README.md must be a page that holds"),
        (("--page", "no.md"), "no.md must be a page"),
    ],
)
def test_bad_arguments_are_one_line(arguments, message):
    """Before anything is measured."""
    done = bench("--quick", *arguments)

    assert done.returncode == 2
    assert message in done.stderr.splitlines()[-1]
