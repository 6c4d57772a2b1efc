"""Chapter 10: determinism. R10.1's comparison with real turtlesim stands in test_ch2_motion.py."""

import os
import re
import subprocess
import sys
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from oracle.arena import OracleArena
from oracle.arithmetic import NEXT_SEED, draw, key, to_float32
from rulebook.conftest import ArenaFactory
from rulebook.episodes import SEED, config_of, digests

from catch_arena.config import RULESET, ArenaConfig
from catch_arena.core.compiler import INTERPRETED
from catch_arena.engine import Engine
from catch_arena.envs.parallel import parallel_env
from catch_arena.errors import ReplayError
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


@pytest.mark.rule("R10.2")
@pytest.mark.parametrize(("changed", "named"), [(0, "initial state"), (1, r"\b1\b"), (17, r"\b17\b"), (30, r"\b30\b")])
def test_r10_2_replaying_names_the_first_step_that_differs(changed: int, named: str) -> None:
    """A digest that does not fit, at the start, in the middle and at the end."""
    _, replay = played()
    digest = bytearray(replay.digests[changed])
    digest[3] ^= 1
    replay.digests[changed] = bytes(digest)
    with pytest.raises(ReplayError, match=named):
        list(replay.worlds())


@pytest.mark.rule("R10.2")
def test_r10_2_a_saved_state_that_is_restored_goes_on_identically() -> None:
    """Here, and in another engine."""
    config = ArenaConfig(hunters=3, control="full", spawn_frequency_hz=5.0, reach_m=2.0)
    engine, other = Engine(config), Engine(config)
    engine.reset([42])
    other.reset([43])
    source = np.random.default_rng(42)
    actions = [(source.integers(0, 3, (1, 3)), source.uniform(-1, 1, (1, 3, 2)).astype(np.float32)) for _ in range(60)]
    for action in actions[:30]:
        engine.step(*action)
    saved = engine.save()
    at_save = engine.digest(0)
    went_on = []
    for action in actions[30:]:
        engine.step(*action)
        went_on.append((engine.digest(0), engine.observations.tobytes(), engine.rulings(0)))
    for copy in (engine, other):
        copy.restore(saved)
        assert copy.digest(0) == at_save
        for action, expected in zip(actions[30:], went_on, strict=True):
            copy.step(*action)
            assert (copy.digest(0), copy.observations.tobytes(), copy.rulings(0)) == expected


@pytest.mark.rule("R10.3")
def test_r10_3_the_ruleset_has_a_number_and_the_book_and_the_env_bear_it() -> None:
    """One number everywhere."""
    assert re.fullmatch(r"catch_arena_v\d+", RULESET)
    assert f"Ruleset `{RULESET}`" in (ROOT / "docs" / "reference" / "rulebook.md").read_text(encoding="utf-8")
    assert str(parallel_env("duel")) == RULESET


GOLDEN = {"faulty": "506d224a19017564", "crowd": "661924edc68ca0d7"}
"""The digests after 40 steps of the episodes under catch_arena_v1."""


@pytest.mark.rule("R10.3")
@pytest.mark.parametrize("name", GOLDEN)
def test_r10_3_equal_inputs_play_as_they_did_when_the_ruleset_got_its_number(name: str) -> None:
    """If this fails, either undo the change or raise the number."""
    assert RULESET == "catch_arena_v1"
    assert digests(name, 40)[-1] == GOLDEN[name]


@pytest.mark.rule("R10.3")
@pytest.mark.parametrize("name", GOLDEN)
def test_r10_3_the_oracle_plays_the_golden_episodes_too(name: str) -> None:
    """So the digests are the book's, not one engine's."""
    config = config_of(name)
    oracle = OracleArena(config.to_dict())
    oracle.reset(SEED)
    source = Random(SEED)
    for _ in range(40):
        choices = [int(3 * source.random()) for _ in range(config.hunters)]
        commands = [(2 * source.random() - 1, 2 * source.random() - 1) for _ in range(config.hunters)]
        oracle.step(
            [
                choice if control == "target" else ((to_float32(command[0]), to_float32(command[1])), choice)
                for control, choice, command in zip(config.controls, choices, commands, strict=True)
            ]
        )
    assert oracle.digest().hex() == GOLDEN[name]
