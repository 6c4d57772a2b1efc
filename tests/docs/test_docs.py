"""Pages that are made from code are up to date, and their examples do what the pages say."""

import dataclasses
import re
import runpy
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import catch_arena
from catch_arena.cli import main
from catch_arena.files import tomllib
from catch_arena.policy import Limits, PreyLimits
from catch_arena.scenarios import SCENARIOS
from catch_arena.tournament.loading import shipped
from catch_arena.training import LearnerBatch, Mlp

ROOT = Path(__file__).parent.parent.parent
PYTHON = re.compile(r"```python(?: file=\S+)?\n(.*?)```", re.DOTALL)


@pytest.mark.large
def test_the_search_on_its_page_gains_what_the_page_says(capsys):
    """Without it that hunter loses; with it, it wins."""
    (code,) = PYTHON.findall((ROOT / "docs" / "howto" / "save_and_search.md").read_text())
    exec(code, {"__name__": "__main__"})  # noqa: S102 - ours
    printed = capsys.readouterr().out.strip()
    own, rivals, own_searching, rivals_then = map(int, re.findall(r"\d+", printed))

    assert code.rstrip().endswith(f"  # {printed}")
    assert own < rivals
    assert own_searching > rivals_then


def test_the_page_about_training_makes_an_agent_that_plays(tmp_path, monkeypatch):
    """In its scenario and in another, alone and in batches, with a network that knows nothing."""
    page = (ROOT / "docs" / "tutorials" / "train_an_agent.md").read_text()
    (code,) = [code for code in PYTHON.findall(page) if "class Agent" in code]
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(code)
    rng = np.random.default_rng(1)
    Mlp([(rng.normal(size=(8, 71)), np.zeros(8)), (rng.normal(size=(9, 8)), np.zeros(9))]).save("mine.npz")
    for scenario in ("standard", "duel"):
        done = CliRunner().invoke(main, ["check-agent", "mine.py", "--scenario", scenario, "--trusted"])
        assert done.exit_code == 0, done.output
    batch = LearnerBatch("standard", 3, opponents="mine.py")
    batch.reset(seed=1)
    for _ in range(5):
        batch.step(np.ones(3, dtype=int))


def test_the_sample_agent_passes_the_sample_spec(tmp_path, monkeypatch):
    """The page about agents and the page about grading are read together."""
    monkeypatch.chdir(tmp_path)
    agent = re.search(
        r"```python file=mine.py\n(.*?)```", (ROOT / "docs" / "reference" / "agents.md").read_text(), re.DOTALL
    )[1]
    spec = re.search(
        r"```toml file=exercise.toml\n(.*?)```", (ROOT / "docs" / "howto" / "grading.md").read_text(), re.DOTALL
    )[1]
    Path("mine.py").write_text(agent)
    Path("exercise.toml").write_text(spec)
    Path("hidden_seed.txt").write_text("c0ffee00" * 4)
    done = CliRunner().invoke(main, ["grade", "mine.py", "--spec", "exercise.toml", "--trusted"])

    assert done.exit_code == 0, done.output
    assert done.output.endswith("mine has 10 of 10 points\n")


def test_whatever_is_said_to_be_installed_is_an_extra():
    """In the pages, and in the errors of the package, the scripts and the examples."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    pages = "".join(page.read_text() for page in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md")))
    folders = ("catch_arena", "scripts", "examples")
    code = "".join(file.read_text() for part in folders for file in (ROOT / part).rglob("*.py"))
    in_pages = {name for names in re.findall(r"'\.\[([a-z0-9,]+)\]'", pages) for name in names.split(",")}
    in_errors = set(re.findall(r"""install_hint\(["']([a-z0-9]+)["']\)""", code))

    assert {"ros", "video", "parquet"} <= in_pages <= extras.keys()
    assert {"ros", "video", "train"} <= in_errors <= extras.keys()
    assert "catch-arena[" not in pages + code  # it is on no index


def test_every_scenario_and_every_shipped_agent_has_a_row():
    """The first table of each page names them all, in any order, and nothing else."""
    for page, names in (("scenarios.md", SCENARIOS), ("shipped_agents.md", shipped())):
        first_table = (ROOT / "docs" / "reference" / page).read_text().partition("\n## ")[0]
        assert sorted(re.findall(r"^\| `(\w+)` \|", first_table, re.MULTILINE)) == sorted(names)


def test_every_public_name_has_an_entry_in_the_reference():
    page = (ROOT / "docs" / "reference" / "api.rst").read_text()
    assert set(re.findall(r":: catch_arena\.(\w+)$", page, re.MULTILINE)) == set(catch_arena.__all__)


def test_the_made_pages_are_up_to_date():
    """`make docs` would change nothing."""
    write_docs = runpy.run_path(str(ROOT / "scripts" / "write_docs.py"))

    made = []
    for name in write_docs["PAGES"]:
        page = (ROOT / "docs" / name).read_text()
        assert page == write_docs["with_tables"](page)
        made += [found[1] for found in write_docs["TABLE"].findall(page)]
    assert made == list(write_docs["TABLES"])


def test_the_page_about_agents_lists_every_limit_with_its_meaning_and_the_units_of_its_name():
    """The names end in their units: metres, seconds, and parts of them."""
    page = (ROOT / "docs" / "reference" / "agents.md").read_text()
    tables = re.findall(r"<!-- made by `make docs`: view.limits.*? -->(.*?)<!-- end -->", page, re.DOTALL)
    units = {"m": "m", "mps": "m/s", "radps": "rad/s", "ms": "ms", "s": "s", "deg": "degrees"}
    for table, kind in zip(tables, (Limits, PreyLimits), strict=True):
        rows = dict(re.findall(r"^\| `(\w+)` \| ([^|]*) \| [^|]{12,} \|$", table, re.MULTILINE))
        assert list(rows) == [field.name for field in dataclasses.fields(kind)]
        for name, unit in rows.items():
            assert unit == units.get(name.rpartition("_")[2], "")
