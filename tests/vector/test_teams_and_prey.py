"""R11 and R12 in the batch: prey stands behind the hunters, and every row plays what one arena plays."""

import re

import numpy as np
import pytest
from vector.test_vector_arena import random_actions

from catch_arena import VectorArena, parallel_env, scenario
from catch_arena.engine.episode_seeds import batch_seeds
from catch_arena.errors import ActionError, ConfigError
from catch_arena.layout import observation_size, prey_observation_size

SEED = 20_261_122
HUNT = scenario(
    "standard",
    hunters=3,
    side_m=4.0,
    prey=3,
    initial_targets=5,
    max_targets=6,
    reach_m=0.6,
    reverse=True,
    prey_returns_s=0.4,
    prey_rewards={"survived": 0.1, "gained": 1.0},
    time_limit_s=2.0,
)
"""Much happens, and episodes are short."""
TEAMS = scenario("squads", side_m=6.0, spawn_frequency_hz=8.0, reach_m=0.6, team_share=0.5, time_limit_s=2.0)


def row_of(config, agent):
    """An agent's place among those of its arena."""
    side, _, index = agent.partition("_")
    return int(index) + (config.hunters if side == "prey" else 0)


def same(observation, row):
    """True if a row of the batch has the numbers of the env, and zeros after them."""
    return observation.tobytes() == row[: len(observation)].tobytes() and not row[len(observation) :].any()


@pytest.mark.rule("R12.7")
@pytest.mark.parametrize(
    "config",
    [HUNT, HUNT.replace(prey=1, prey_returns_s=None), HUNT.replace(hunters=12, prey_rewards={"gained": 0.0})],
    ids=str,
)
def test_r12_7_a_row_plays_what_the_one_arena_env_plays_through_several_episodes(config):
    """Observations, rewards and who is active in every step, last observations and figures of every episode. Prey that
    is out for good keeps its row here, and has left there.
    """
    arena, row, source = VectorArena(config, 40), 37, np.random.default_rng(SEED)
    observations, infos = arena.reset(seed=SEED)
    env = parallel_env(config)
    seen, notes = env.reset(seed=int(batch_seeds(SEED, 40)[row]))
    returns, caught, episodes = np.zeros(config.prey), np.zeros(config.prey), 0
    for _ in range(3 * config.max_steps + 5):
        for agent, observation in seen.items():
            assert same(observation, observations[row, row_of(config, agent)])
        actions = random_actions(config, 40, source)
        observations, rewards, terminations, truncations, infos = arena.step(**actions)
        one = {f"hunter_{seat}": int(actions["choices"][row, seat]) for seat in range(config.hunters)}
        one |= {f"prey_{i}": actions["commands"][row, config.hunters + i] for i in range(config.prey)}
        seen, gained, _, _, notes = env.step({agent: one[agent] for agent in env.agents})
        for agent, reward in gained.items():
            agent_row = row_of(config, agent)
            assert np.float32(reward) == rewards[row, agent_row]
            if agent_row >= config.hunters:
                returns[agent_row - config.hunters] += reward
                caught[agent_row - config.hunters] += notes[agent]["caught_by"] != -1
        over = terminations[row] or truncations[row]
        if not over:
            in_play = [prey.target is not None for prey in env.world().prey]
            assert infos["active"][row].tolist() == [True] * config.hunters + in_play
            continue
        assert infos["_final_obs"][row]
        for agent, observation in seen.items():
            assert same(observation, infos["final_obs"][row, row_of(config, agent)])
        figures = infos["episode"]
        np.testing.assert_allclose(figures["return"][row, config.hunters :], returns, rtol=1e-5, atol=1e-5)
        assert figures["times_caught"][row].tolist() == caught.tolist()
        assert figures["rank"][row, config.hunters :].tolist() == [
            1 + sum(other < mine for other in caught) for mine in caught
        ]
        assert (figures["length"][row] == env.world().step).all()
        returns[:], caught[:] = 0.0, 0.0
        seen, notes = env.reset()
        episodes += 1
    assert episodes == 3


@pytest.mark.rule("R12.5")
def test_r12_5_prey_in_an_arena_that_has_ended_is_paid_nothing_until_its_reset():
    """The other arena was reset later, and plays on."""
    arena, source = VectorArena(HUNT, 2, auto_reset=False), np.random.default_rng(SEED)
    arena.reset(seed=SEED)
    for step in range(HUNT.max_steps + 1):
        if step == 3:
            arena.reset(arenas=[1])
        _, rewards, _, truncations, _ = arena.step(**random_actions(HUNT, 2, source))
    assert truncations.tolist() == [True, False]
    assert [rewards[row, HUNT.hunters :].any() for row in (0, 1)] == [False, True]


@pytest.mark.rule("R11.1")
def test_r11_1_figures_rank_by_team_and_infos_tell_team_scores():
    """Both teams' members have one rank and one team's score, which is the sum of what they caught."""
    arena, source = VectorArena(TEAMS, 40), np.random.default_rng(SEED)
    arena.reset(seed=SEED)
    for step in range(TEAMS.max_steps):
        before = arena.world(3).team_scores
        *_, infos = arena.step(source.integers(0, 3, (40, 8)))
        if step < TEAMS.max_steps - 1:
            assert tuple(infos["team_score"][3]) == arena.world(3).team_scores
            assert all(now >= then for now, then in zip(infos["team_score"][3], before, strict=True))
    figures = infos["episode"]
    scores = figures["score"].reshape(40, 2, 4).sum(axis=2)
    assert (figures["team_score"].reshape(40, 2, 4) == scores[:, :, None]).all()
    best = scores == scores.max(axis=1, keepdims=True)
    assert (figures["rank"].reshape(40, 2, 4) == np.where(best, 1, 2)[:, :, None]).all()
    assert 0 < best.all(axis=1).sum() < 40  # ties, and others
    assert not infos["team_score"].any()  # of the episodes that have begun


def test_shapes_and_spaces_are_those_of_the_agents():
    arena = VectorArena(HUNT, 4)
    observations, infos = arena.reset(seed=1)
    own, of_prey = observation_size(HUNT), prey_observation_size(HUNT)
    assert observations.shape == (4, 6, max(own, of_prey))
    assert [arena.observation_space(agent).shape for agent in (1, 3, 5)] == [(own,), (of_prey,), (of_prey,)]
    assert (arena.action_space(1).n, arena.action_space(3).shape) == (HUNT.targets_seen + 1, (2,))
    assert infos["active"].all()
    with pytest.raises(ConfigError, match="agent must be a whole number from 0 to 5, got 'prey'"):
        arena.observation_space("prey")
    with pytest.raises(ConfigError, match="agent must be a whole number from 0 to 3, got 4"):
        VectorArena("standard", 2).action_space(4)
    source = np.random.default_rng(1)
    for _ in range(HUNT.max_steps):
        observations, *_ = arena.step(**random_actions(HUNT, 4, source))
        for agent in range(6):
            space = arena.observation_space(agent)
            assert all(space.contains(row) for row in observations[:, agent, : space.shape[0]])
            assert not observations[:, agent, space.shape[0] :].any()


NAN = np.zeros((4, 6, 2))
NAN[1, 5, 0] = np.nan


@pytest.mark.parametrize(
    ("commands", "message"),
    [
        (None, "commands must be numbers of the shape (4, 6, 2), got None"),
        (
            np.zeros((4, 3, 2)),
            "commands must be numbers of the shape (4, 6, 2), got an array of float64 of the shape (4, 3, 2)",
        ),
        (NAN, "in arena 1 for prey_2"),
    ],
)
def test_bad_commands_are_named_and_nothing_moves(commands, message):
    arena = VectorArena(HUNT, 4)
    arena.reset(seed=1)
    digest = arena.digest(2)
    with pytest.raises(ActionError, match=re.escape(message)):
        arena.step(np.zeros((4, 3), int), commands)
    assert arena.digest(2) == digest
