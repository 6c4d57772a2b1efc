"""Saving a replay replaces only regular files, and the same match gives the same bytes."""

from pathlib import Path

import pytest

import catch_arena
from catch_arena.errors import OutputError


def test_only_regular_files_are_replaced(mixed, tmp_path):
    """A device or a folder stays what it is; a link is followed."""
    for target in (tmp_path, Path("/dev/null")):
        with pytest.raises(OutputError, match="is not a regular file"):
            mixed.save(target)
    (tmp_path / "real.replay").write_bytes(b"")
    (tmp_path / "link.replay").symlink_to(tmp_path / "real.replay")
    mixed.save(tmp_path / "link.replay")

    assert (tmp_path / "link.replay").is_symlink()
    assert catch_arena.Replay.load(tmp_path / "real.replay").steps == mixed.steps


def test_hunters_that_leave_in_one_step_may_do_so_in_any_order(tmp_path):
    """Which of two agents that fail together is noticed first is chance."""
    contents = []
    for order in (("hunter_0", "hunter_1"), ("hunter_1", "hunter_0")):
        env = catch_arena.parallel_env("duel", max_cycles=3)
        env.record()
        env.reset(seed=1)
        for agent in order:
            env.withdraw(agent)
        env.step(dict.fromkeys(env.agents, 0))
        env.replay().save(tmp_path / "match.replay")
        assert catch_arena.Replay.load(tmp_path / "match.replay").withdrawals == [(0, 0), (0, 1)]
        contents.append((tmp_path / "match.replay").read_bytes())
    assert contents[0] == contents[1]
