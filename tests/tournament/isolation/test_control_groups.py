"""Where control groups are delegated, and what the kernel bounds in them.

The tests marked `cgroups` need such a group; `make cgroups` runs them in one. The others use a tree of plain files.
"""

import os
import re
import signal
import subprocess
import sys
import time

import pytest
from isolation_levels import LEVELS
from tournament.isolation.greedy_agents import FREE, SHORT, reason_of

from catch_arena.descendants import LINUX
from catch_arena.tournament.entrants import enter
from catch_arena.tournament.isolation import control_groups, levels
from catch_arena.tournament.isolation.control_groups import AgentGroup, ControlGroups, delegated_group
from catch_arena.tournament.isolation.inspecting import inspector
from catch_arena.tournament.isolation.levels import level_line
from catch_arena.tournament.isolation.limits import AgentLimits
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.isolation.starting import start_players
from catch_arena.tournament.match_loop import play

pytestmark = pytest.mark.skipif(not LINUX, reason="only Linux has control groups")

NEAREST = """
class Agent:
    def reset(self, seed):
        pass

    def act(self, view):
        return min(1, len(view.targets))
"""
SOCKETS = """
        self.kept = []
        with socket.create_server(("127.0.0.1", 0)) as server:
            for _ in range(24):
                self.kept += [socket.create_connection(server.getsockname()), server.accept()[0]]
        for end in self.kept:
            end.settimeout(0.05)
            with suppress(TimeoutError):
                while True:
                    end.send(bytes(1 << 18))
"""
FORGOTTEN = """
        for _ in range(10):
            if os.fork() == 0:
                shared = mmap.mmap(-1, 20 << 20)
                shared.write(bytes([1]) * len(shared))
                shared.madvise(mmap.MADV_DONTNEED)
                time.sleep(60)
"""
FORKS = """
        with suppress(OSError):
            for _ in range(2000):
                if os.fork() == 0:
                    time.sleep(60)
"""


class Tree:
    """A tree of groups of plain files, and a process's place in it."""

    def __init__(self, folder):
        self.mount = folder / "cgroup"
        self.membership = folder / "membership"
        self.group("", controllers="")

    def group(self, place, controllers="cpuset cpu io memory pids"):
        folder = self.mount / place
        folder.mkdir(parents=True)
        (folder / "cgroup.controllers").write_text(controllers + "\n")
        for name in ("cgroup.procs", "cgroup.subtree_control", *(("cgroup.type",) if place else ())):
            (folder / name).touch()
        return folder

    def found_from(self, place):
        self.membership.write_text(f"12:pids:/old\n0::/{place}\n")
        return delegated_group(self.mount, self.membership)


@pytest.fixture
def tree(tmp_path, monkeypatch):
    made = Tree(tmp_path)
    monkeypatch.setattr(control_groups, "_is_marked", lambda group: (group / "marked").exists())
    return made


def marked(group):
    (group / "marked").touch()
    return group


def test_the_nearest_group_that_is_marked_as_delegated_is_found(tree):
    marked(tree.group("user"))
    nearest = marked(tree.group("user/scope"))
    tree.group("user/scope/below")
    assert tree.found_from("user/scope") == nearest
    assert tree.found_from("user/scope/below") == nearest


def test_a_group_of_somebody_elses_is_not_used(tree):
    tree.group("session")
    assert tree.found_from("session") is None


def test_the_root_of_the_machine_needs_no_mark_and_that_of_a_container_does(tree):
    (tree.mount / "cgroup.controllers").write_text("memory pids\n")
    assert tree.found_from("") == tree.mount
    (tree.mount / "cgroup.type").touch()
    assert tree.found_from("") is None
    marked(tree.mount)
    assert tree.found_from("") == tree.mount


@pytest.mark.parametrize("controllers", ["", "memory", "pids cpu"])
def test_a_group_without_memory_or_processes_is_not_used(tree, controllers):
    marked(tree.group("scope", controllers))
    assert tree.found_from("scope") is None


@pytest.mark.parametrize("text", ["", "4:memory:/scope\n", "0::scope\n"])
def test_where_there_is_only_the_older_version_none_is_found(tree, text):
    marked(tree.group("scope"))
    tree.membership.write_text(text)
    assert delegated_group(tree.mount, tree.membership) is None


def test_where_a_place_leads_out_of_the_tree_none_is_found(tree):
    assert tree.found_from("../scope") is None


def test_without_a_membership_none_is_found(tmp_path):
    assert delegated_group(tmp_path, tmp_path / "none") is None


def test_what_the_kernel_says_of_its_end(tmp_path):
    group = AgentGroup(tmp_path)
    assert not group.excess()
    (tmp_path / "memory.events").write_text("low 0\nhigh 0\nmax 17\noom 0\noom_kill 0\n")
    assert not group.excess()
    (tmp_path / "memory.events").write_text("low 0\nhigh 0\nmax 23\noom 1\noom_kill 3\noom_group_kill 1\n")
    assert group.excess()


def test_people_are_told_of_control_groups(tmp_path, monkeypatch):
    monkeypatch.setattr(levels, "delegated_group", lambda: None)
    assert level_line("namespaces") == "isolation: namespaces"
    monkeypatch.setattr(levels, "delegated_group", lambda: tmp_path)
    assert level_line("processes") == (
        "isolation: processes, see `catch-arena docs isolation`; control groups bound memory and processes"
    )


def groups_of_agents():
    """Their folders."""
    folder = delegated_group()
    assert folder is not None, "make cgroups runs this in a group that is delegated"
    return sorted(folder.glob("catch-arena-*-*"))


@pytest.mark.cgroups
@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("what", [SOCKETS, FORGOTTEN], ids=["in sockets", "shared and released"])
def test_memory_that_no_process_has_at_hand_is_bounded(tmp_path, level, what):
    found = reason_of(tmp_path, what, level=level, memory_mib=32)
    assert found == "act: its processes together held more than twice 32 MiB (memory_mib)"
    assert groups_of_agents() == []


@pytest.mark.cgroups
@pytest.mark.parametrize("level", LEVELS)
def test_who_forks_without_end_is_told_which_limit_it_passed(tmp_path, level):
    assert reason_of(tmp_path, FORKS, level=level, processes=40) == (
        "act: it had more than 40 processes and threads (processes)"
    )
    assert groups_of_agents() == []


@pytest.mark.cgroups
@pytest.mark.parametrize("level", LEVELS)
def test_each_agent_has_a_group_of_its_own_with_its_bounds(tmp_path, level):
    paths = [tmp_path / name / "agent.py" for name in ("ann", "bob")]
    for path in paths:
        path.parent.mkdir()
        path.write_text(NEAREST)
    with Sandbox(AgentLimits(**FREE, level=level, memory_mib=100, file_mib=10, processes=30)) as sandbox:
        entrants = enter([str(path) for path in paths], inspector(sandbox))
        with start_players(entrants, sandbox) as players:
            assert play(SHORT, 1, players, ["ann", "bob"]).forfeits == (None, None)
            groups = groups_of_agents()
            assert len(groups) == 2
            for group in groups:
                files_mib = 20 if level == "namespaces" else 0
                assert int((group / "memory.max").read_text()) == (200 + files_mib) << 20
                assert (group / "memory.oom.group").read_text() == "1\n"
                assert (group / "pids.max").read_text() == "94\n"
                pids = {int(pid) for pid in (group / "cgroup.procs").read_text().split()}
                assert len(pids) >= 1
                assert os.getpid() not in pids
    assert groups_of_agents() == []


@pytest.mark.cgroups
def test_groups_of_a_supervisor_that_was_killed_are_removed_by_the_next_one(tmp_path):
    path = tmp_path / "agent.py"
    path.write_text(NEAREST)
    with Sandbox(AgentLimits(**FREE)) as sandbox:
        entrants = enter([str(path), "idle"], inspector(sandbox))
        with start_players(entrants, sandbox) as players:
            play(SHORT, 1, players, ["agent", "idle"])
        assert len(groups_of_agents()) == 1
        os.kill(sandbox.pid, signal.SIGKILL)
        patience = time.monotonic() + 10
        while "populated 1" in (groups_of_agents()[0] / "cgroup.events").read_text():
            assert time.monotonic() < patience
            time.sleep(0.01)
    assert len(groups_of_agents()) == 1
    ControlGroups.here()
    assert groups_of_agents() == []


@pytest.mark.cgroups
def test_a_command_says_so(tmp_path):
    path = tmp_path / "agent.py"
    path.write_text(NEAREST)
    words = [
        sys.executable,
        "-m",
        "catch_arena",
        "match",
        str(path),
        "idle",
        "--scenario",
        "duel",
        "--set",
        "time_limit_s=1",
    ]
    said = subprocess.run(words, capture_output=True, text=True, check=True, cwd=tmp_path).stderr
    assert re.search(r"^isolation: .*; control groups bound memory and processes$", said, re.MULTILINE)
