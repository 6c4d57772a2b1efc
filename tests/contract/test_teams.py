"""R11.1 in the environments: teams, their scores, and equal configs for equal teams."""

import pytest
from contract.episodes import chased

import catch_arena
from catch_arena.layout import columns

BUSY = catch_arena.scenario("pairs", side_m=4.0, spawn_frequency_hz=6.0, reach_m=0.6, max_cycles=60)


@pytest.mark.rule("R11.1")
def test_r11_1_world_and_infos_tell_the_teams_and_their_scores():
    """A team's score is the sum of its hunters'."""
    env = catch_arena.parallel_env(BUSY.replace(teams=((3, 0), (1, 2))))
    scored = 0
    for _, (*_, infos) in chased(env, 3):
        world = env.world()
        assert [hunter.team for hunter in world.hunters] == [0, 1, 1, 0]
        scores = [hunter.score for hunter in world.hunters]
        assert world.team_scores == (scores[0] + scores[3], scores[1] + scores[2])
        for hunter in world.hunters:
            assert infos[hunter.name]["team_score"] == world.team_scores[hunter.team]
        scored = sum(scores)
    assert scored > 20


@pytest.mark.rule("R11.1")
def test_r11_1_the_order_in_which_a_teams_seats_are_named_changes_nothing():
    """The configs are equal."""
    one, other = BUSY, BUSY.replace(teams=((1, 0), (3, 2)))
    assert one == other
    assert one.digest == other.digest


def test_without_teams_nothing_speaks_of_them():
    """Each hunter is a team of its own."""
    env = catch_arena.parallel_env()
    _, infos = env.reset(seed=1)
    assert "team_score" not in infos["hunter_0"]
    assert [hunter.team for hunter in env.world().hunters] == [0, 1, 2, 3]
    assert not [column.name for column in columns(env.config) if column.name.endswith("mate")]
    assert "team_score" not in catch_arena.VectorArena("standard", 2).reset(seed=1)[1]
