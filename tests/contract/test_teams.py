"""R11.1, R11.2 in every interface: whose rival is a mate, what a team has caught, and what its members get."""

import numpy as np
import pytest
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test

import catch_arena
from catch_arena.core.state import PART_NAMES
from catch_arena.layout import columns

BUSY = catch_arena.scenario("pairs", side_m=4.0, spawn_frequency_hz=6.0, reach_m=0.6, max_cycles=60)


def played(env, seed):
    """Each step of one episode in which everybody wants the nearest target: what `step` gives."""
    _, infos = env.reset(seed=seed)
    while env.agents:
        step = env.step({agent: int(infos[agent]["action_mask"][1]) for agent in env.agents})
        infos = step[-1]
        yield step


@pytest.mark.rule("R11.1")
def test_r11_1_world_and_infos_tell_the_teams_and_their_scores():
    """A team's score is the sum of its hunters'."""
    env = catch_arena.parallel_env(BUSY.replace(teams=((3, 0), (1, 2))))
    scored = 0
    for *_, infos in played(env, 3):
        world = env.world()
        assert [hunter.team for hunter in world.hunters] == [0, 1, 1, 0]
        scores = [hunter.score for hunter in world.hunters]
        assert world.team_scores == (scores[0] + scores[3], scores[1] + scores[2])
        for hunter in world.hunters:
            assert infos[hunter.name]["team_score"] == world.team_scores[hunter.team]
        scored = sum(scores)
    assert scored > 20


@pytest.mark.rule("R11.2")
def test_r11_2_team_mates_share_what_they_earn():
    """With a share of 1 they get the same, the mean; the parts stay their own."""
    shared, own = catch_arena.parallel_env(BUSY), catch_arena.parallel_env(BUSY.replace(team_share=0.0))
    different = 0
    for (_, rewards, _, _, infos), (_, alone, _, _, others) in zip(played(shared, 5), played(own, 5), strict=True):
        assert rewards["hunter_0"] == rewards["hunter_1"] == (alone["hunter_0"] + alone["hunter_1"]) / 2
        assert rewards["hunter_2"] == rewards["hunter_3"] == (alone["hunter_2"] + alone["hunter_3"]) / 2
        for agent in rewards:
            assert infos[agent]["reward_parts"].tolist() == others[agent]["reward_parts"].tolist()
        different += rewards != alone
    assert different > 10


@pytest.mark.rule("R11.2")
def test_r11_2_catches_of_mates_and_of_rivals_are_told_apart():
    """Together they are all others' catches."""
    env = catch_arena.parallel_env(BUSY.replace(team_share=0.0, rewards={"rival_catch": -1.0, "mate_catch": 0.5}))
    met = 0
    for _, rewards, _, _, infos in played(env, 9):
        parts_of = {agent: dict(zip(PART_NAMES, infos[agent]["reward_parts"], strict=True)) for agent in rewards}
        caught = {agent: parts["catch"] for agent, parts in parts_of.items()}
        for pair in (("hunter_0", "hunter_1"), ("hunter_2", "hunter_3")):
            for agent, mate in (pair, pair[::-1]):
                parts = parts_of[agent]
                assert parts["mate_catch"] == caught[mate]
                assert parts["rival_catch"] == sum(caught.values()) - caught[agent] - caught[mate]
                assert rewards[agent] == caught[agent] - parts["rival_catch"] + 0.5 * caught[mate]
                met += parts["mate_catch"] > 0
    assert met > 10


@pytest.mark.rule("R7.4")
def test_r7_4_a_rival_is_marked_as_a_mate_wherever_it_stands():
    """By the places of the rivals in the world."""
    env = catch_arena.parallel_env(BUSY)
    names = [column.name for column in columns(env.config)]
    at = {name: names.index(name) for name in names if name.startswith("rival")}
    marks = set()
    for observations, *_ in played(env, 2):
        hunters = env.world().hunters
        for me in hunters:
            seen = observations[me.name]
            others = sorted(
                (other for other in hunters if other is not me), key=lambda o: (o.x - me.x) ** 2 + (o.y - me.y) ** 2
            )
            for rank, other in enumerate(others, start=1):
                distance = np.hypot(seen[at[f"rival_{rank}.forward"]], seen[at[f"rival_{rank}.left"]])
                assert distance == pytest.approx(np.hypot(other.x - me.x, other.y - me.y), abs=1e-4)
                assert seen[at[f"rival_{rank}.mate"]] == (other.team == me.team)
            marks.add(tuple(seen[at[f"rival_{rank}.mate"]] for rank in (1, 2, 3)))
    assert marks == {(1, 0, 0), (0, 1, 0), (0, 0, 1)}


@pytest.mark.rule("R11.1")
def test_r11_1_the_order_in_which_a_teams_seats_are_named_changes_nothing():
    """It is one config."""
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


@pytest.mark.parametrize("name", ["pairs", "squads"])
def test_teams_pass_pettingzoos_tests(name):
    """API, AEC and seeds, warnings being errors."""
    parallel_api_test(catch_arena.parallel_env(name, max_cycles=30), num_cycles=50)
    parallel_seed_test(lambda: catch_arena.parallel_env(name, max_cycles=30), num_cycles=20)
    api_test(catch_arena.env(name, max_cycles=20), num_cycles=50)
