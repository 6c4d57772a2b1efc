"""Chapter 12 in both envs: prey is among the agents, is caught, leaves or returns, and is withdrawn."""

import numpy as np
import pytest
from contract.episodes import chase, chased

import catch_arena
from catch_arena.errors import ActionError, EpisodeError
from catch_arena.layout import prey_columns

HUNT = catch_arena.scenario(
    "herd", side_m=5.0, prey=3, initial_targets=4, max_targets=6, reach_m=0.5, prey_returns_s=0.5, max_cycles=80
)


@pytest.mark.rule("R12.7")
def test_r12_7_prey_comes_after_the_hunters_with_spaces_of_its_own():
    env = catch_arena.parallel_env(HUNT)
    assert env.possible_agents == [*(f"hunter_{seat}" for seat in range(4)), "prey_0", "prey_1", "prey_2"]
    assert env.observation_space("prey_1").shape == (len(prey_columns(HUNT)),) == (9 + 6 * 4 + 6 * 2,)
    assert env.action_space("prey_1").shape == (2,)
    assert env.observation_space("prey_0") is env.observation_space("prey_0")
    assert [prey.target for prey in (env.reset(seed=1) and env.world()).prey] == [
        f"target_turtle_{n}" for n in (1, 2, 3)
    ]


@pytest.mark.rule("R12.3")
def test_r12_3_prey_that_returns_stays_among_the_agents():
    """The info says when prey is out, and who caught it; then all columns but two are zero."""
    env = catch_arena.parallel_env(HUNT)
    names = [column.name for column in prey_columns(HUNT)]
    caught = returned = 0
    for seed in range(3):
        before = [0, 0, 0]
        was_active = [True] * 3
        for agents, (observations, rewards, terminations, _, infos) in chased(env, seed):
            assert agents == env.possible_agents
            assert not any(terminations.values())
            for index, prey in enumerate(env.world().prey):
                info, seen = infos[prey.name], observations[prey.name]
                assert env.observation_space(prey.name).contains(seen)
                assert info["active"] is (prey.target is not None)
                assert (info["caught_by"] != -1) == (prey.times_caught > before[index])
                assert seen[names.index("times_caught")] == prey.times_caught
                assert seen[names.index("alive")] == info["active"]
                if info["caught_by"] != -1:
                    assert infos[f"hunter_{info['caught_by']}"]["verdict"] == catch_arena.Verdict.GRANTED
                    assert rewards[prey.name] == -1.0
                    assert info["reward_parts"].tolist() == [1.0, 0.0, 0.0]
                    caught += 1
                if not info["active"]:
                    assert {names[at] for at in np.flatnonzero(seen)} <= {"time_left", "times_caught"}
                returned += info["active"] and not was_active[index]
                before[index], was_active[index] = prey.times_caught, info["active"]
    assert caught > 5
    assert returned > 5


@pytest.mark.rule("R12.3")
def test_r12_3_prey_that_does_not_return_is_terminated_and_leaves():
    """With its last observation, once, and never truncated too."""
    config = HUNT.replace(prey_returns_s=None)
    env = catch_arena.parallel_env(config)
    left = 0
    for seed in range(4):
        gone: set[str] = set()
        for agents, (observations, rewards, terminations, truncations, infos) in chased(env, seed):
            assert set(observations) == set(rewards) == set(terminations) == set(infos) == set(agents)
            out = {prey.name for prey in env.world().prey if prey.target is None}
            assert {agent for agent in agents if terminations[agent]} == out - gone
            assert not any(terminations[agent] and truncations[agent] for agent in agents)
            for agent in out - gone:
                assert rewards[agent] == -1.0
                assert observations[agent][7] == 1
            gone = out
            left += len(gone & set(agents))
            if env.agents:
                assert set(env.agents) == set(env.possible_agents) - gone
    assert left > 5


@pytest.mark.rule("R12.5")
def test_r12_5_prey_is_withdrawn_stands_still_and_can_be_caught():
    """Prey is terminated in the next step, with rewards of zero; the others see it."""
    config = HUNT.replace(prey_rewards={"survived": 1.0, "gained": 1.0}, reach_m=0.01)
    env = catch_arena.parallel_env(config)
    _, infos = env.reset(seed=7)
    for _ in range(5):
        *_, infos = env.step(chase(env, infos))
    env.withdraw("prey_1")
    (target,) = (target for target in env.world().targets if target.prey == "prey_1")
    assert target.linear_velocity == target.angular_velocity == 0.0
    actions = chase(env, infos)
    _, rewards, terminations, _, infos = env.step(actions)
    assert [agent for agent, over in terminations.items() if over] == ["prey_1"]
    assert rewards["prey_1"] == 0.0
    assert not infos["prey_1"]["reward_parts"].any()
    assert "prey_1" not in env.agents
    (still,) = (target for target in env.world().targets if target.prey == "prey_1")
    assert (still.x, still.y, still.theta) == (target.x, target.y, target.theta)
    assert env.world().prey[1].withdrawn
    with pytest.raises(EpisodeError, match="cannot withdraw prey_1: it is not among the agents"):
        env.withdraw("prey_1")
    env.step(chase(env, infos))


@pytest.mark.parametrize("action", [2, [0.5], [0.5, -float("inf")], "ahead", [float("nan"), 0.0], None])
def test_an_action_that_prey_cannot_give_is_refused(action):
    """Nothing moves."""
    env = catch_arena.parallel_env(HUNT)
    _, infos = env.reset(seed=1)
    digest = env.digest()
    with pytest.raises(ActionError, match="prey_2: an action must be two finite numbers, got "):
        env.step(chase(env, infos) | {"prey_2": action})
    assert env.digest() == digest


@pytest.mark.rule("R7.3")
def test_r7_3_the_global_view_tells_of_prey():
    """The state lies in its space, and says which prey is out."""
    env = catch_arena.parallel_env(HUNT)
    for _ in chased(env, 4):
        state = env.state()
        assert env.state_space.contains(state)
        for prey, columns in zip(env.world().prey, state[-27:].reshape(3, 9), strict=True):
            assert columns[0] == (prey.target is not None)
            assert columns[7] == prey.times_caught
