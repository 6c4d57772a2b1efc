"""A word on the command line becomes an entrant with a name and a digest, or an error that explains why not."""

import copy
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from catch_arena.errors import AgentError
from catch_arena.tournament.agent_spec import resolve, unique_names
from catch_arena.tournament.entrants import Entrant
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.loading import create_policy
from catch_arena.tournament.players import enter

HOLDS = "class Agent:\n    def reset(self, seed): pass\n    def act(self, view): return 0\n"


@pytest.fixture
def agent_file(tmp_path):
    def write(source: str, name: str = "mine.py") -> str:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(source)
        return str(path)

    return write


def test_an_agent_is_a_shipped_name_a_class_in_a_module_or_a_file(agent_file):
    path = agent_file(HOLDS)
    shipped, classed, filed = enter(["patrol", "catch_arena.agents.first:Agent", path])
    assert (shipped.name, shipped.control) == ("patrol", "velocity")
    assert (classed.name, classed.control) == ("Agent", "target")
    assert (filed.name, filed.spec) == ("mine", path)
    assert create_policy(filed.spec).act(None) == 0


def test_files_of_one_name_are_named_by_what_tells_their_places_apart(agent_file):
    """Students hand in a folder each, with the same file name."""
    files = ["ann/hw1/agent.py", "bob/hw1/agent.py", "bob/hw2/agent.py", "cid/nearest.py", "cid/other.py"]
    files.append("dan/__init__.py")
    words = [*(agent_file(HOLDS, name) for name in files), "nearest", "catch_arena.agents.first:Agent"]
    second = agent_file(HOLDS, "nearest#2.py")
    twice = enter([*words, words[0], "catch_arena.agents.idle:Agent", second, "nearest"])
    files = ["ann/hw1/agent", "bob/hw1/agent", "hw2/agent", "cid/nearest", "other", "dan"]
    again = ["nearest#2", "nearest#3"]
    assert [one.name for one in twice] == [*files, "nearest", "first/Agent", "ann/hw1/agent#2", "idle/Agent", *again]
    assert len({one.name for one in enter(["nearest", "nearest", second])}) == 3


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be"])
def test_a_file_in_another_encoding_is_told_which(tmp_path, encoding):
    """Trusted or not."""
    path = tmp_path / "mine.py"
    path.write_text(HOLDS, encoding=encoding)
    why = f"{path}: is not UTF-8: save it as UTF-8"
    with Sandbox(Quotas()) as sandbox:
        faults = [enter([str(path)], within)[0].fault for within in (None, sandbox)]
    assert faults == [why, why]


PREY = "class Prey:\n    def reset(self, seed): pass\n    def act(self, view): return 0.0, 0.0\n"


@pytest.mark.parametrize("borrowed", ["Agent", "Prey"])
def test_the_digest_is_also_of_a_module_that_a_class_is_borrowed_from(agent_file, tmp_path, monkeypatch, borrowed):
    monkeypatch.syspath_prepend(tmp_path)
    agent_file(HOLDS + PREY, f"home_of_{borrowed}.py")
    own = f"from home_of_{borrowed} import {borrowed}\n" + (PREY if borrowed == "Agent" else HOLDS)
    agent_file(own, f"borrows_{borrowed}.py")
    specs = [f"borrows_{borrowed}:Agent", agent_file(own, "filed.py")]
    before = enter(specs)
    agent_file(HOLDS + PREY + "# changed\n", f"home_of_{borrowed}.py")
    assert not {one.digest for one in before} & {one.digest for one in enter(specs)}


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        (
            "import nothing_of_this_name\n",
            "which is not installed here; if nothing_of_this_name is a file of yours, give a folder with agent.py",
        ),
        ("class Agent\n", "importing it raised SyntaxError"),
        ("raise SystemExit(0)\n", "importing it raised SystemExit"),
        ("class Agnet: pass\n", "has no class Agent; did you mean Agnet"),
        ("Agent = 3\n", "has no class Agent"),
        ("class Agent:\n    def reset(self, seed): pass\n", "Agent must have a method act"),
        ("class Agent:\n    def act(self, view): pass\n", "Agent must have a method reset"),
        ("class Agent:\n    def __init__(self, x): pass\n", r"Agent\(\) raised TypeError"),
        (HOLDS + "    control = 'fly'\n", "control must be target, velocity or full, got 'fly'"),
        (HOLDS + "    @property\n    def control(self): return 1 / 0\n", r"Agent\(\) raised ZeroDivisionError"),
    ],
)
def test_a_file_that_cannot_play_is_named_with_the_reason_in_one_line(agent_file, source, reason):
    (entrant,) = enter([agent_file(source)])
    assert re.search(reason, entrant.fault)
    assert "mine.py" in entrant.fault
    assert "\n" not in entrant.fault


@pytest.mark.parametrize(
    ("spec", "reason"),
    [
        ("", "an agent must be a name, a file, a folder or a command, got ''"),
        ("neerest", "unknown agent 'neerest': did you mean nearest"),
        ("missing.py", "missing.py: no such file"),
        ("~unknown_user", "unknown agent '~unknown_user'"),
        ("~unknown_user/mine.py", "^~unknown_user/mine.py: no such file"),
        ("cmd:~unknown_user/bot", "^~unknown_user/bot: no such file"),
        ("missing.zip", "^missing.zip: no such file; give a shipped agent's name, a .py file, a folder"),
        ("helpers", r"^helpers: no such file; a file is given with its ending, as helpers\.py$"),
        (
            "neighbours.py",
            r"it imports helpers, which is not installed here; .* a folder with agent\.py and helpers",
        ),
        ("ann.py:Agent", "ann.py:Agent: a file is given alone, and its class is called Agent: ann.py"),
        ("catch_arena.agents.nearest:Agnt", "has no class Agnt; did you mean Agent"),
        ("no_such_module:Agent", "no module no_such_module is installed"),
        ("notes.ipynb", "notes.ipynb: is a notebook; save the code of its agent as a .py file"),
        ("notebook.py", "notebook.py: is a notebook; save the code of its agent as a .py file"),
        ("X.PY", "X.PY: must be a .py file or a folder with agent.py; rename it to X.py"),
        (
            "agent.txt",
            "agent.txt: must be a .py file or a folder with agent.py; other programs are given as cmd:COMMAND",
        ),
        ("empty", "empty: is a folder without agent.py, which holds the class Agent"),
        ("folder.py", r"folder\.py: is a folder, and its name must not end in \.py"),
        ("/", r"^/: holds all temporary files, and an agent sees its whole folder: move agent\.py into a folder"),
        ("linked", r"linked: its agent\.py is a link, and an isolated agent sees only its folder: copy it"),
        ("loop.py", "loop.py: is a link that leads to no file"),
        ("cmd:./dos.sh", "./dos.sh: its lines end as on Windows"),
        ("cmd:./mark.sh", r"^\./mark\.sh: begins with a byte order mark, which hides its #!: sed -i "),
        (
            "cmd:./lacks.sh",
            "./lacks.sh: its first line names the interpreter '/no/such/sh', which is not installed here",
        ),
        ("cmd:./lacks_env.sh", "its first line names the interpreter 'no_such_program', which is not installed here"),
        ("cmd:./plain.sh", "./plain.sh: must be executable: chmod"),
        ("cmd:", r"^cmd: must name a command, as in cmd:\./my_bot$"),
        ("cmd:'open", "No closing quotation"),
        ("cmd:no_such_program --x", "^no_such_program: is not found in PATH$"),
        ("cmd:./no_such.sh --x", r"^\./no_such\.sh: no such file$"),
        ("cmd:./empty", r"^\./empty: is no program$"),
        ("latin.py", r"/latin\.py: is not UTF-8: save it as UTF-8$"),
        (
            "helpers:Agent",
            r"^helpers: no module helpers is installed; a file is given with its ending, as helpers\.py$",
        ),
        ("helpers.mine:Agent", r"^helpers\.mine: no module helpers is installed$"),
    ],
)
def test_a_word_that_stands_for_nothing_is_explained(tmp_path, monkeypatch, spec, reason):
    monkeypatch.chdir(tmp_path)
    notebook = '{"cells": [{"cell_type": "code", "source": []}], "nbformat": 4}'
    for name, content in {
        "notes.ipynb": notebook,
        "notebook.py": notebook,
        "X.PY": HOLDS,
        "agent.txt": HOLDS,
        "neighbours.py": "from helpers import chase\n",
        "helpers.py": "def chase(): pass\n",
        "latin.py": f"name = 'Zoë'\n{HOLDS}",
        "plain.sh": "#!/bin/sh\n",
        "dos.sh": "#!/bin/sh\r\necho\r\n",
        "mark.sh": "ï»¿#!/bin/sh\n",
        "lacks.sh": "#!/no/such/sh\n",
        "lacks_env.sh": "#!/usr/bin/env no_such_program\n",
    }.items():
        (tmp_path / name).write_bytes(content.encode("latin-1"))
        (tmp_path / name).chmod(0o644 if name == "plain.sh" else 0o755)
    for folder in ("empty", "folder.py"):
        (tmp_path / folder).mkdir()
    (tmp_path / "loop.py").symlink_to("loop.py")
    (tmp_path / "linked").mkdir()
    (tmp_path / "linked" / "agent.py").symlink_to(tmp_path / "helpers.py")
    if spec in {"neighbours.py", "latin.py", "no_such_module:Agent", "helpers:Agent", "helpers.mine:Agent"}:
        why = enter([spec])[0].fault  # an agent's own fault, for which it forfeits
    else:
        with pytest.raises(AgentError) as refusal:
            enter([spec])
        why = str(refusal.value)
    assert re.search(reason, why)
    assert "\n" not in why


def test_a_commands_words_that_are_no_files_stay_as_they_are(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "b").touch()
    program = resolve("cmd:python3 s/../b b")
    assert program.spec == f"cmd:{shutil.which('python3')} s/../b {tmp_path / 'b'}"


def test_a_commands_name_and_digest_come_from_its_file_whatever_it_says(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def entered(word, *sources):
        agent = resolve(f"cmd:sh {word}")
        return Entrant(*unique_names([agent]), agent.spec, "target", agent.digest(sources))

    (tmp_path / "other").mkdir()
    for name in ("mine.sh", "other/mine.sh"):
        (tmp_path / name).write_text("echo\n")
    mine, same = entered("mine.sh"), entered(f"{tmp_path}/other/mine.sh", str(tmp_path / "mine.sh"))
    assert entered("mine.sh", "a" * 300, "\0").digest == entered("mine.sh").digest
    with_option = entered("mine.sh --fast")
    (tmp_path / "mine.sh").write_text("echo changed\n")
    changed = entered("mine.sh")
    assert mine.name == same.name == changed.name == "mine"
    assert mine.digest == same.digest
    assert len({mine.digest, with_option.digest, changed.digest}) == 3


EARLY = """
import helper
class Agent:
    def reset(self, seed): pass
    def act(self, view): return helper.CHOICE
"""
LATE = """
class Agent:
    def __init__(self):
        from helper import CHOICE
        self.choices = [CHOICE]
    def reset(self, seed):
        from package import deeper
        self.choices.append(deeper.CHOICE)
        self.act = self.choose
    def act(self, view):
        return 0
    def choose(self, view):
        from helper import CHOICE
        from package import deeper
        return CHOICE if self.choices == [CHOICE, deeper.CHOICE] else 0
"""


@pytest.mark.parametrize("source", [EARLY, LATE])
def test_an_agent_may_be_a_folder_whose_modules_are_its_own(agent_file, source):
    """Two folders have modules of one name; each agent has its own, whenever it imports them, and none is left where
    others could import it.
    """
    for name, choice in (("ann", 1), ("bob", 2)):
        agent_file(f"CHOICE = {choice}\n", f"{name}/helper.py")
        agent_file("import helper\nCHOICE = helper.CHOICE\n", f"{name}/package/deeper.py")
        agent_file(source, f"{name}/agent.py")
    folders = [str(Path(agent_file(HOLDS)).parent / name) for name in ("ann", "bob")]
    entrants = enter(folders)
    assert [one.name for one in entrants] == ["ann", "bob"]
    agents = [copy.deepcopy(create_policy(one.spec)) for one in entrants]
    for agent in agents:
        agent.reset(0)
    for _ in range(2):
        assert [agent.act(None) for agent in agents] == [1, 2]
    assert not {"helper", "package"} & set(sys.modules)
    assert not set(folders) & set(sys.path)
    agent_file("CHOICE = 3\n", "ann/helper.py")
    assert enter(folders)[0].digest != entrants[0].digest


def test_a_module_in_the_starting_folder_is_not_found(tmp_path, monkeypatch):
    """`python -m` would find it and the command would not, and it would be trusted."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])  # as `python -m` does
    (tmp_path / "only_here.py").write_text(HOLDS)
    assert "no module only_here is installed" in enter(["only_here:Agent"])[0].fault
    (tmp_path / "mine.py").write_text(f"import only_here\n{HOLDS}")
    assert "it imports only_here, which is not installed here" in enter([str(tmp_path / "mine.py")])[0].fault


def test_python_m_does_not_search_the_starting_folder_later_either(tmp_path):
    (tmp_path / "only_here.py").write_text("")
    (tmp_path / "mine.py").write_text(HOLDS.replace("return 0", "import only_here; return 0"))
    words = ["-m", "catch_arena", "match", "mine.py", "idle", "-s", "duel", "--set", "time_limit_s=1", "--trusted"]
    done = subprocess.run([sys.executable, *words], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "act raised ModuleNotFoundError: No module named 'only_here'" in done.stdout


def test_a_link_is_an_agent_under_its_own_name_whatever_it_leads_to(agent_file, tmp_path):
    agent_file(HOLDS, "store/77b0de")
    (tmp_path / "ann.py").symlink_to("store/77b0de")
    (tmp_path / "ann.npz").write_bytes(b"learned")
    (linked,) = enter([str(tmp_path / "ann.py")])
    assert (linked.name, linked.spec) == ("ann", str(tmp_path / "ann.py"))
    (tmp_path / "ann.npz").write_bytes(b"learned more")
    assert enter([str(tmp_path / "ann.py")])[0].digest != linked.digest
