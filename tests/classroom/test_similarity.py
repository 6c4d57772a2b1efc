"""Equal and nearly equal submissions are noticed; agents that people wrote on their own are not."""

import re
from pathlib import Path

import pytest

from catch_arena.classroom.similarity import similar_pairs
from catch_arena.classroom.starters import write_agent_kit
from catch_arena.classroom.submissions import find_submissions

AGENTS = Path(__file__).parents[2] / "agents"
ORIGINAL = (AGENTS / "pure_pursuit.py").read_text()


def pairs_of(folder, files):
    for name, text in files.items():
        (folder / f"{name}.py").write_text(text)
    return [(pair.first, pair.second, pair.equal) for pair in similar_pairs(find_submissions(folder)[0])]


def renamed(text):
    """Return a program with other names, comments and numbers, in other lines."""
    words = {"target": "prey_thing", "view": "v", "speed": "pace", "turn": "rot", "decide": "choose", "limits": "lim"}
    for old, new in words.items():
        text = re.sub(rf"\b{old}\b", new, text)
    text = re.sub(r'""".*?"""', '"""Mine."""', text, flags=re.DOTALL)
    return "# my own work\n" + re.sub(r"\b2\.0\b", "2.5", text).replace("\n\n", "\n\n\n")


def test_people_who_handed_in_nothing_have_not_copied(tmp_path):
    for name in ("ann", "ben"):
        (tmp_path / name).mkdir()
    assert similar_pairs(find_submissions(tmp_path)[0]) == []


@pytest.mark.parametrize("change", [lambda text: text, renamed, lambda text: text.replace("\n", "\r\n")])
def test_a_copy_is_noticed_under_other_names(tmp_path, change):
    files = {"ann": ORIGINAL, "ben": change(ORIGINAL), "cem": (AGENTS / "patrol.py").read_text()}
    assert pairs_of(tmp_path, files) == [("ann", "ben", change(ORIGINAL) == ORIGINAL)]


def test_agents_of_different_ideas_are_not_noticed():
    assert similar_pairs(find_submissions(AGENTS)[0]) == []


def test_what_most_of_a_class_has_is_no_sign(tmp_path):
    """The code of the exercise is in all submissions; without it, only two are alike."""
    own = {f"s{number}": (AGENTS / f"{name}.py").read_text() for number, name in enumerate(("tour", "pid", "triage"))}
    files = {name: f"{ORIGINAL}\n{text}" for name, text in own.items()}
    files |= {f"copy{number}": files["s0"] for number in range(2)} | {f"t{number}": ORIGINAL for number in range(2)}
    found = pairs_of(tmp_path, files)
    assert {(first, second) for first, second, equal in found if not equal} == set()
    assert ("copy0", "copy1", True) in found


def test_what_new_agent_writes_is_no_sign(tmp_path):
    """Two students have the kit's files and agents of their own."""
    for name in ("pure_pursuit", "patrol"):
        write_agent_kit(tmp_path / name)
        (tmp_path / name / "own.py").write_text((AGENTS / f"{name}.py").read_text())
    assert similar_pairs(find_submissions(tmp_path)[0]) == []


def test_what_all_three_of_a_class_have_is_no_sign(tmp_path):
    own = {name: (AGENTS / f"{name}.py").read_text() for name in ("tour", "pid", "triage")}
    assert pairs_of(tmp_path, {name: f"{ORIGINAL}\n{text}" for name, text in own.items()}) == []


@pytest.mark.parametrize("text", ["class Agent(:", "x = 1\0", "(" * 5000, "def f():\n" * 3000])
def test_a_file_that_is_no_python_is_compared_by_its_bytes_only(tmp_path, text):
    assert pairs_of(tmp_path, {"ann": text, "ben": text, "cem": f"{text} "}) == [("ann", "ben", True)]
