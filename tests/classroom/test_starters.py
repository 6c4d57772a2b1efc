"""`new-agent` and `new-class` write what can be used at once: it plays, its test runs, and its workflow works."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import run
from ruamel.yaml import YAML

BIN = Path(sys.executable).parent


@pytest.fixture
def kit(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = run("new-agent", "turtle-eater")
    assert done.exit_code == 0, done.output
    assert sorted(done.stdout.split()) == sorted(
        f"turtle-eater/{path.relative_to(tmp_path / 'turtle-eater')}"
        for path in (tmp_path / "turtle-eater").rglob("*")
        if path.is_file()
    )
    monkeypatch.chdir(tmp_path / "turtle-eater")
    return tmp_path / "turtle-eater"


def test_a_new_agent_is_fit_to_play_and_passes_every_rule_of_ruff(kit):
    assert (kit / "README.md").read_text().startswith("# turtle-eater\n")
    assert len((kit / "README.md").read_text().splitlines()) == 10
    fit = run("check-agent", ".", "--scenario", "duel")
    assert (fit.exit_code, "warning" in fit.output) == (0, False), fit.output
    assert fit.stdout.endswith("turtle-eater is fit to play\n")
    for command in (
        ["ruff", "check", "--isolated", "--select", "ALL", "--ignore", "D203,D213,COM812,INP001,PT009,CPY001", "."],
        ["ruff", "format", "--isolated", "--check", "."],
    ):
        done = subprocess.run([BIN / command[0], *command[1:]], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout


def test_the_commands_of_the_workflow_run_here_and_leave_the_artifact(kit):
    """All but those that install; the spec is made shorter."""
    spec = kit / "exercise.toml"
    spec.write_text(spec.read_text().replace("matches = 6", "matches = 2"))
    (job,) = YAML(typ="safe").load((kit / ".github" / "workflows" / "grade.yml").read_text())["jobs"].values()
    ran = []
    for words in (step["run"].split() for step in job["steps"] if "run" in step):
        if words[0] == "catch-arena":
            assert run(*words[1:]).exit_code in {0, 1}
        elif words[:1] == ["python"]:
            subprocess.run([sys.executable, *words[1:]], check=True, capture_output=True)
        else:
            assert re.match(r"sudo apt-get install|pip install", " ".join(words))
            continue
        ran.append(words[1])
    assert ran == ["-m", "check-agent", "grade"]
    (kept,) = (step["with"]["path"] for step in job["steps"] if "upload-artifact" in step.get("uses", ""))
    grades = json.loads((kit / kept / "grades.json").read_text())
    assert grades["points"] >= 4
    assert (kit / kept / "grades.xml").stat().st_size


@pytest.mark.parametrize("command", ["new-agent", "new-class"])
def test_a_folder_with_files_is_left_as_it_is(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    Path("mine").mkdir()
    Path("mine/agent.py").write_text("mine")
    refused = run(command, "mine")
    assert (refused.exit_code, refused.stderr) == (
        2,
        "error: mine: already exists; choose the name of a new or an empty folder\n",
    )
    assert [path.read_text() for path in Path("mine").iterdir()] == ["mine"]


def test_the_sample_class_has_a_good_submission_a_copy_and_three_mistakes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("new-class", "course").exit_code == 0
    spec = Path("course/exercise.toml")
    spec.write_text(spec.read_text().replace("matches = 6", "matches = 4"))
    limits = ["--limit", "bank_s=2"]
    done = run("grade", "course/submissions", "--spec", spec, "--jobs", "2", *limits)
    assert done.exit_code == 0, done.output
    points = dict(re.findall(r"^(\w+): (\d+) of 10 points$", done.stdout, re.MULTILINE))
    assert points == {"ann": "10", "ben": "10", "cem": "0", "dana": "0", "eli": points["eli"]}
    assert int(points["eli"]) < 10
    assert re.findall("^look at these two: (.*?):", done.stdout, re.MULTILINE) == ["ann and ben"]
