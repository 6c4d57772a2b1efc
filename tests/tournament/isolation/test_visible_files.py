"""Which files an agent sees in namespaces of its own, decided from folders made for it."""

import sys
from pathlib import Path

import pytest

import catch_arena
from catch_arena.tournament.isolation.visible_files import visible_files


@pytest.fixture
def folder(tmp_path):
    """A folder with these files, by their paths in it."""

    def make(*names):
        for name in names:
            path = tmp_path / "bots" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(name)
        return tmp_path / "bots"

    return make


def seen(folder, files):
    """What of a folder is seen."""
    return {str(path.relative_to(folder)) for path in {*files.shown, *files.links} if path.is_relative_to(folder)}


def test_an_agent_sees_the_folder_that_it_has_to_itself(folder):
    bots = folder("a.py", "weights.npz", "data/table.csv")
    assert seen(bots, visible_files(f"{bots}/a.py")) == {"a.py", "weights.npz", "data"}


def test_of_a_shared_folder_it_sees_what_is_nobody_elses(folder):
    """What begins with a program's name is that program's, the longest name first."""
    bots = folder("a.py", "a.npz", "a-data/x", "a_2.py", "a_2.npz", "ab.py", "ab.npz", "abc.txt", "common.csv")
    assert seen(bots, visible_files(f"{bots}/a.py")) == {"a.py", "a.npz", "a-data", "abc.txt", "common.csv"}
    assert seen(bots, visible_files(f"{bots}/a_2.py")) == {"a_2.py", "a_2.npz", "abc.txt", "common.csv"}
    assert seen(bots, visible_files(f"{bots}/ab.py")) == {"ab.py", "ab.npz", "abc.txt", "common.csv"}


def test_other_entrants_folders_are_not_seen_from_above(folder):
    bots = folder("a.py", "ann/agent.py", "ann/weights.npz", "data/x")
    specs = [f"{bots}/a.py", f"{bots}/ann/agent.py"]
    assert seen(bots, visible_files(specs[0], specs)) == {"a.py", "data"}
    assert seen(bots, visible_files(specs[1], specs)) == {"ann/agent.py", "ann/weights.npz"}


def test_what_the_tournament_writes_and_is_given_is_not_seen(folder):
    bots = folder("a.py", "weights.npz", "exam.toml", "out/results.sqlite", "deep/out/replays/m.replay")
    hidden = [f"{bots}/exam.toml", f"{bots}/out", f"{bots}/deep/out", f"{bots}/not_there"]
    assert seen(bots, visible_files(f"{bots}/a.py", (), hidden)) == {"a.py", "weights.npz"}


def test_in_a_folder_that_results_are_written_to_it_sees_only_what_has_its_name(folder):
    bots = folder("a.py", "a.npz", "standings.json", "results.sqlite")
    assert seen(bots, visible_files(f"{bots}/a.py", (), [str(bots)])) == {"a.py", "a.npz"}


def test_in_somebodys_home_it_sees_only_what_has_its_name(folder, monkeypatch):
    bots = folder("a.py", "a.npz", "taxes.pdf", ".ssh/id_rsa", "work/x")
    monkeypatch.setenv("HOME", str(bots))
    assert seen(bots, visible_files(f"{bots}/a.py")) == {"a.py", "a.npz"}
    monkeypatch.setenv("HOME", str(bots / "work"))
    assert seen(bots, visible_files(f"{bots}/a.py")) == {"a.py", "a.npz"}


def test_hidden_files_are_not_seen(folder):
    bots = folder("a.py", ".env", ".git/config", "__pycache__/b.cpython-311.pyc")
    assert seen(bots, visible_files(f"{bots}/a.py")) == {"a.py"}


def test_a_link_shows_nothing_that_it_leads_to(folder, tmp_path):
    bots = folder("a.py")
    (tmp_path / "exam.toml").write_text("secret")
    (bots / "weights.npz").symlink_to(tmp_path / "exam.toml")
    files = visible_files(f"{bots}/a.py")
    assert files.links[bots / "weights.npz"] == str(tmp_path / "exam.toml")
    assert not files.covers(tmp_path / "exam.toml")


def test_a_command_sees_the_files_that_it_names_and_what_is_beside_them(folder):
    bots = folder("ann/bot.js", "ann/lib.js", "ann/classes/Bot.class", "bob/bot.js")
    node, java = f"cmd:/usr/bin/node {bots}/ann/bot.js", f"cmd:/usr/bin/java -cp=/usr/x:{bots}/ann/classes Bot"
    other = f"cmd:/usr/bin/node {bots}/bob/bot.js"
    assert seen(bots, visible_files(node, [node, other])) == {"ann/bot.js", "ann/lib.js", "ann/classes"}
    assert seen(bots, visible_files(java, [java, other])) == {"ann/classes"}


def test_commands_in_one_folder_do_not_see_each_others_files(folder):
    bots = folder("a.js", "a.json", "b.js", "b.json", "lib.js")
    specs = [f"cmd:/usr/bin/node {bots}/{name}.js" for name in "ab"]
    assert seen(bots, visible_files(specs[0], specs)) == {"a.js", "a.json", "lib.js"}


def test_a_program_in_a_folder_bin_sees_its_libraries(folder):
    bots = folder("runtime/bin/node", "runtime/lib/modules/x", "runtime/share/secret", "bot.js")
    spec = f"cmd:{bots}/runtime/bin/node {bots}/bot.js"
    assert seen(bots, visible_files(spec)) >= {"runtime/bin/node", "runtime/lib", "bot.js"}
    assert not visible_files(f"cmd:{bots}/runtime/bin/node").covers(bots / "runtime/share")


def test_a_module_sees_its_package_without_the_files_of_other_entrants(folder, monkeypatch):
    bots = folder("team/__init__.py", "team/ann.py", "team/bob.py", "other.py", "alone.py", "alone.npz", "notes.txt")
    monkeypatch.syspath_prepend(bots)
    specs = ["team.ann:Agent", "team.bob:Agent", "alone:Agent"]
    files = visible_files(specs[0], specs)
    assert seen(bots, files) == {"team"}
    assert files.masked == {bots / "team/bob.py"}
    assert seen(bots, visible_files(specs[2], specs)) == {"alone.py", "alone.npz"}
    assert "team" not in sys.modules


def test_every_agent_sees_the_interpreter_and_this_package_and_no_more_of_a_checkout():
    files = visible_files("/nowhere/a.py")
    package = Path(catch_arena.__file__).parent
    for path in (Path(sys.executable), Path(sys.base_prefix), package / "policy.py", Path(np_file())):
        assert files.covers(path) or path in files.links, path
    assert not files.covers(Path(__file__))
    assert not files.covers(Path("/etc/passwd"))


def np_file():
    import numpy as np

    return np.__file__


def test_links_on_the_way_to_the_interpreter_stay_links(folder, tmp_path, monkeypatch):
    runtime = folder("runtime/bin/python").parent / "bots" / "runtime"
    (tmp_path / "venv").symlink_to(runtime)
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "venv"))
    files = visible_files("/nowhere/a.py")
    assert files.links[tmp_path / "venv"] == str(runtime)
    assert files.covers(runtime / "bin" / "python")


def test_a_link_that_leads_to_itself_does_no_harm(tmp_path):
    (tmp_path / "a.py").symlink_to(tmp_path / "a.py")
    (tmp_path / "cmd").symlink_to("cmd")
    visible_files(f"{tmp_path}/a.py")
    visible_files(f"cmd:{tmp_path}/cmd")
