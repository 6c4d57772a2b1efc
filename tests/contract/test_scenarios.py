"""Every scenario in every interface, by the tests of those who use it: PettingZoo, SuperSuit, tournaments, grades."""

import json
from pathlib import Path

import numpy as np
import pytest
import supersuit
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test
from typer.testing import CliRunner

import catch_arena
from catch_arena.cli import main
from catch_arena.layout import columns
from catch_arena.replay import Replay
from catch_arena.replay.verification import verify

SCENARIOS = list(catch_arena.SCENARIOS)
UNCERTAIN = ["wander", "evasive", "fog", "blinkers", "unequal", "dropout"]
"""Those in which something moves, is not seen, differs by seat or leaves."""


# what PettingZoo says of prey, which sees otherwise than hunters
@pytest.mark.filterwarnings("ignore:Agents have different observation space")
@pytest.mark.filterwarnings("ignore:Observations are different shapes")
@pytest.mark.parametrize("name", SCENARIOS)
def test_a_scenario_passes_pettingzoos_tests(name):
    """API, AEC and seeds, warnings being errors."""
    parallel_api_test(catch_arena.parallel_env(name, max_cycles=30), num_cycles=60)
    parallel_seed_test(lambda: catch_arena.parallel_env(name, max_cycles=30), num_cycles=20)
    api_test(catch_arena.env(name, max_cycles=20), num_cycles=60)


@pytest.mark.rule("R1.7")
@pytest.mark.parametrize("dropouts", ["leave", "fixed"])
def test_r1_7_supersuits_black_death_keeps_the_agents_that_have_left(dropouts):
    """It gives those zeros; who drops out and stays has observations of its own, and rewards of zero.

    SuperSuit 3.11 ends where all agents are terminated and truncated at once, or where none is left: a step later.
    """
    left = 0
    for seed in range(4):
        plain = catch_arena.parallel_env("dropout", dropout_rate=0.05, max_cycles=30, dropouts=dropouts)
        env = supersuit.black_death_v3(plain)
        observations, _ = env.reset(seed=seed)
        steps = 0
        while env.agents:
            assert env.agents == env.possible_agents
            before = set(plain.agents)
            on = plain.world().step
            observations, rewards, *_ = env.step(dict.fromkeys(env.agents, 1))
            steps += plain.world().step - on
            assert set(observations) == set(rewards) == set(plain.possible_agents)
            for agent in set(plain.possible_agents) - before:
                assert rewards[agent] == 0
                assert observations[agent].shape == plain.observation_space(agent).shape
                assert not observations[agent].any()
                left += bool(before)
            for hunter in env.unwrapped.world().hunters:
                assert rewards[hunter.name] == 0 or not hunter.withdrawn
        assert steps == 30 or all(hunter.withdrawn for hunter in plain.world().hunters)
    assert left > 10 if dropouts == "leave" else left == 0


@pytest.mark.rule("R1.7")
@pytest.mark.parametrize("dropouts", ["leave", "fixed"])
def test_r1_7_agent_by_agent_the_same_match_is_played(dropouts):
    """AEC: who has dropped out is asked for one last action, None, and then no more; the states are the same."""
    for seed in range(3):
        settings = {"dropout_rate": 0.05, "max_cycles": 25, "dropouts": dropouts}
        one, other = catch_arena.parallel_env("dropout", **settings), catch_arena.env("dropout", **settings)
        one.reset(seed=seed)
        digests = [one.digest()]
        while one.agents:
            one.step(dict.fromkeys(one.agents, 1))
            digests.append(one.digest())
        other.reset(seed=seed)
        met, gone = [other.unwrapped.digest()], set()
        for agent in other.agent_iter():
            assert agent not in gone
            _, _, terminated, truncated, _ = other.last()
            if terminated or truncated:
                gone.add(agent)
            other.step(None if terminated or truncated else 1)
            if other.unwrapped.digest() != met[-1]:
                met.append(other.unwrapped.digest())
        assert met == digests
        assert gone == set(other.possible_agents)


@pytest.mark.parametrize("name", UNCERTAIN)
def test_a_tournament_is_played_rated_and_recorded(name, tmp_path):
    """With nobody forfeiting, and replays that are true."""
    out = tmp_path / "results"
    words = ["nearest", "intercept", "first", "idle", "--scenario", name, "--set", "time_limit_s=4"]
    result = CliRunner().invoke(main, ["tournament", *words, "--rounds", "1", "--record", "--out", str(out)])
    assert result.exit_code == 0, result.output
    assert "forfeit" not in result.output.lower()
    replays = sorted((out / "replays").rglob("*.replay"))
    assert replays
    for path in replays[:2]:
        replay = Replay.load(path)
        assert list(verify(replay)) == []
        assert replay.config.dropout_rate == catch_arena.SCENARIOS[name].dropout_rate


def test_an_exercise_in_fog_and_with_dropouts_is_graded(tmp_path, monkeypatch):
    """By a spec, whose points are given for the score that stays."""
    monkeypatch.chdir(tmp_path)
    Path("spec.toml").write_text(
        "title = 'Eyes'\n"
        "seed = 1\nmatches = 2\n"
        + "".join(
            f"[[test]]\nname = '{name}'\nscenario = '{name}'\nsettings = {{ time_limit_s = 10 }}\n"
            "opponents = ['idle', 'idle', 'idle']\npoints = 1\nmin_mean_score = 1\n"
            for name in ("fog", "dropout", "evasive")
        )
    )
    result = CliRunner().invoke(main, ["grade", "intercept", "--spec", "spec.toml", "--json", "grades.json"])
    assert result.exit_code == 0, result.output
    assert "intercept has 3 of 3 points" in result.output
    assert json.loads(Path("grades.json").read_text())


@pytest.mark.parametrize("name", UNCERTAIN)
def test_a_batch_plays_what_an_env_plays(name):
    """R10.1: the same states row by row, though who drops out stays in it."""
    config = catch_arena.scenario(name, max_cycles=25)
    env, batch = catch_arena.parallel_env(config), catch_arena.VectorArena(config, 3, auto_reset=False)
    env.reset(seed=9)
    batch.reset(seed=[8, 9, 10])
    action = np.array([1.0, 0.3], np.float32) if config.control == "velocity" else np.int64(1)
    choices, commands = np.ones((3, config.hunters), int), np.full((3, config.hunters, 2), (1.0, 0.3), np.float32)
    while env.agents:
        batch.step(choices, commands)
        env.step(dict.fromkeys(env.agents, action))
        assert env.digest() == batch.digest(1)


@pytest.mark.parametrize("name", ["fog", "blinkers"])
def test_who_sees_nothing_can_look_around(name):
    """Driven in arcs, each hunter sees a target again and again; under target control it could only hold."""
    batch = catch_arena.VectorArena(name, 8)
    batch.reset(seed=1)
    present = [column.name for column in columns(batch.config)].index("target_1.present")
    seen = []
    for _ in range(200):
        observations = batch.step(commands=np.tile(np.array([1.0, 0.25], np.float32), (8, batch.config.hunters, 1)))[0]
        seen.append(observations[..., present] > 0)
    assert np.array(seen[-60:]).any(axis=0).all()
