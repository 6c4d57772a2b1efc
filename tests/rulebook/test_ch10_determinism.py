"""Chapter 10: determinism. R10.1's comparison with real turtlesim stands in test_ch2_motion.py."""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from oracle.arithmetic import NEXT_SEED, draw, key
from rulebook.conftest import ArenaFactory
from rulebook.episodes import digests

from catch_arena.config import RULESET
from catch_arena.core.modes import INTERPRETED
from catch_arena.envs.parallel import parallel_env
from catch_arena.replay import Replay

ROOT = Path(__file__).parents[2]


def digests_apart(name: str, steps: int, **environment: str) -> list[str]:
    """An episode's digests, played in a process of its own."""
    finished = subprocess.run(
        [sys.executable, str(Path(__file__).with_name("episodes.py")), name, str(steps)],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
    )
    lines = finished.stdout.split()
    assert len(lines) == steps
    return lines


@pytest.mark.rule("R10.1")
@pytest.mark.parametrize("name", ["faulty", "crowd"])
def test_r10_1_another_process_with_another_hash_seed_plays_the_same_episode(name: str) -> None:
    """A whole minute, every step's digest."""
    here = digests(name, 600)
    assert here == digests_apart(name, 600, PYTHONHASHSEED="2" if os.environ.get("PYTHONHASHSEED") == "1" else "1")
    assert len(set(here)) == 600


@pytest.mark.rule("R10.1")
def test_r10_1_interpreted_and_compiled_play_the_same_episode() -> None:
    """One here, the other in a process of its own."""
    assert digests("crowd", 25) == digests_apart("crowd", 25, NUMBA_DISABLE_JIT=str(int(not INTERPRETED)))


@pytest.mark.rule("R10.1")
def test_r10_1_the_same_seed_and_actions_give_the_same_trajectory(arena: ArenaFactory) -> None:
    """After a reset in between, and not with another seed."""
    match = arena(hunters=3, control="full", initial_targets=8, spawn_frequency_hz=5.0, faults={"kill_refused": 0.3})
    runs = []
    for seed in (5, 6, 5):
        match.reset(seed)
        run = []
        for step in range(30):
            match.step(*(((0.7, 0.4 - 0.3 * seat), (step + seat) % 3) for seat in range(3)))
            run.append((match.digest(), match.rewards, match.evidence(), match.observation(2)))
        runs.append(run)
    assert runs[0] == runs[2]
    assert runs[0] != runs[1]


@pytest.mark.rule("R10.1")
def test_r10_1_a_further_reset_without_a_seed_goes_on_from_the_last_one() -> None:
    """So a run of many episodes is repeated by its first seed (A.5, purpose 9)."""
    env = parallel_env("duel")
    env.reset(seed=77)
    env.reset()
    second = env.digest()
    env.reset(seed=draw(key(77, NEXT_SEED), 0))
    assert env.digest() == second
    env.reset(seed=77)
    assert env.digest() != second


def test_the_first_reset_without_a_seed_draws_one() -> None:
    """Each env another one, which `reset` takes again."""
    first, second = parallel_env("duel"), parallel_env("duel")
    first.record()
    first.reset()
    second.reset()
    drawn = first.digest()
    assert drawn != second.digest()
    second.reset(seed=first.replay().seed)
    assert second.digest() == drawn


def played(path: Path | None = None) -> tuple[Any, Replay]:
    """A short recorded match with a withdrawal, and its env."""
    env = parallel_env("duel", hunters=3, control=("target", "velocity", "full"), time_limit_s=3.0)
    env.record(names=["ann", "bob", "cid"], title="a test")
    env.reset(seed=2**64 - 1)
    for agent in env.agents:
        env.action_space(agent).seed(9)
    while env.agents:
        if env.world().step == 11:
            env.withdraw("hunter_1")
        env.step({agent: env.action_space(agent).sample() for agent in env.agents})
    replay = env.replay()
    if path is not None:
        replay.save(path)
    return env, replay


@pytest.mark.rule("R10.2", "R1.6")
def test_r10_2_a_replay_plays_the_match_again(tmp_path: Path) -> None:
    """From its file: header, seed, actions and the withdrawal give the same worlds."""
    env, _ = played(tmp_path / "match.replay")
    replay = Replay.load(tmp_path / "match.replay")
    assert (replay.seed, replay.names, replay.title) == (2**64 - 1, ("ann", "bob", "cid"), "a test")
    assert replay.config == env.config
    worlds = list(replay.worlds())
    assert len(worlds) == replay.steps + 1 == 31
    assert worlds[-1] == env.world()
    assert [world.hunters[1].withdrawn for world in worlds] == [False] * 12 + [True] * 19


@pytest.mark.rule("R10.3")
def test_r10_3_the_ruleset_has_a_number_and_the_book_and_the_env_bear_it() -> None:
    """One number everywhere."""
    assert re.fullmatch(r"catch_arena_v\d+", RULESET)
    assert f"Ruleset `{RULESET}`" in (ROOT / "docs" / "reference" / "rulebook.md").read_text(encoding="utf-8")
    assert str(parallel_env("duel")) == RULESET
