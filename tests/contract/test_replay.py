"""Replays keep matches: saved, loaded and played again they agree step by step, and whatever is not one is refused."""

import random
from pathlib import Path

import pytest

import catch_arena
from catch_arena.errors import OutputError, ReplayError

CONTROL = ("target", "velocity", "full", "target")


def record(**overrides):
    env = catch_arena.parallel_env("faulty", control=CONTROL, max_cycles=80, **overrides)
    env.record(["a", "b", "c", "d"], title="a test")
    env.reset(seed=6)
    for index, agent in enumerate(env.possible_agents):
        env.action_space(agent).seed(index)
    worlds = [env.world()]
    while env.agents:
        if len(worlds) == 40:
            env.withdraw("hunter_2")
        env.step({agent: env.action_space(agent).sample() for agent in env.agents})
        worlds.append(env.world())
    return env.replay(), worlds


@pytest.fixture(scope="module")
def recorded():
    return record()


def test_a_replay_plays_the_match_again(recorded, tmp_path):
    """From the file, every world is the one that was, withdrawals and velocity commands included."""
    replay, worlds = recorded
    replay.save(tmp_path / "match.replay")
    loaded = catch_arena.Replay.load(tmp_path / "match.replay")

    assert list(loaded.worlds()) == worlds
    assert (loaded.names, loaded.title, loaded.seed) == (("a", "b", "c", "d"), "a test", 6)
    assert loaded.config == replay.config


def test_a_standard_match_fits_in_40_kb(tmp_path):
    """60 s with four hunters."""
    env = catch_arena.parallel_env(control="velocity")
    env.record()
    env.reset(seed=1)
    while env.agents:
        env.step({agent: env.action_space(agent).sample() for agent in env.agents})
    env.replay().save(tmp_path / "match.replay")

    assert (tmp_path / "match.replay").stat().st_size < 40_000


def test_the_first_step_that_differs_is_named(recorded):
    """One altered action: its step is the first whose digest cannot be met."""
    replay, _ = recorded
    twin = catch_arena.Replay(replay.config, replay.seed, replay.names, replay.title)
    twin.choices = [choices.copy() for choices in replay.choices]
    twin.commands = [commands.copy() for commands in replay.commands]
    twin.digests, twin.withdrawals = replay.digests, replay.withdrawals
    twin.commands[22][1] = -twin.commands[22][1]
    with pytest.raises(ReplayError, match="step 23 is the first that differs"):
        list(twin.worlds())


def test_damaged_files_are_refused_with_a_clear_line(recorded, tmp_path):
    """Every truncation, and 400 flipped bytes: never a traceback from deep inside, never a wrong match."""
    replay, _ = recorded
    good = tmp_path / "good.replay"
    replay.save(good)
    content = good.read_bytes()
    bad = tmp_path / "bad.replay"
    rng = random.Random(8)
    cuts = [content[:length] for length in (0, 1, 7, 8, 19, 20, 51, 52, len(content) // 2, len(content) - 1)]
    flips = []
    for _ in range(400):
        at = rng.randrange(len(content))
        flips.append(content[:at] + bytes([content[at] ^ (1 + rng.randrange(255))]) + content[at + 1 :])
    for damaged in [*cuts, *flips, content + b"x", b"\x00" * 100, b"PK\x03\x04 something else"]:
        bad.write_bytes(damaged)
        with pytest.raises(ReplayError, match=r"bad\.replay: "):
            catch_arena.Replay.load(bad)
    with pytest.raises(ReplayError, match=r"none\.replay: cannot be read"):
        catch_arena.Replay.load(tmp_path / "none.replay")


def test_a_file_that_cannot_be_written_leaves_nothing(recorded, tmp_path):
    """A folder that is not there: our own error, and no half-written file."""
    replay, _ = recorded
    with pytest.raises(OutputError, match="cannot be written"):
        replay.save(tmp_path / "nowhere" / "match.replay")

    assert list(tmp_path.iterdir()) == []


def test_only_regular_files_are_replaced(recorded, tmp_path):
    """A device or a folder stays what it is; a link is followed."""
    replay, _ = recorded
    for target in (tmp_path, Path("/dev/null")):
        with pytest.raises(OutputError, match="is not a regular file"):
            replay.save(target)
    (tmp_path / "real.replay").write_bytes(b"")
    (tmp_path / "link.replay").symlink_to(tmp_path / "real.replay")
    replay.save(tmp_path / "link.replay")

    assert (tmp_path / "link.replay").is_symlink()
    assert catch_arena.Replay.load(tmp_path / "real.replay").steps == replay.steps
