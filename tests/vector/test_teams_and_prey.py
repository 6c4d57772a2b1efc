"""R11 and R12 in the batch: prey stands behind the hunters, and every row plays what one arena plays."""

import re

import numpy as np
import pytest
from vector.test_vector_arena import HUNT, random_actions

from catch_arena import VectorArena, scenario
from catch_arena.errors import ActionError, ConfigError
from catch_arena.layout import observation_size, prey_observation_size

SEED = 20_261_122
TEAMS = scenario("squads", side_m=6.0, spawn_frequency_hz=8.0, reach_m=0.6, team_share=0.5, time_limit_s=2.0)


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
