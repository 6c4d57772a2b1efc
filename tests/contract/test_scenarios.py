"""SuperSuit keeps agents that have left."""

import pytest
import supersuit

import catch_arena


@pytest.mark.rule("R1.7")
@pytest.mark.parametrize("dropouts", ["leave", "fixed"])
def test_r1_7_supersuits_black_death_keeps_the_agents_that_have_left(dropouts):
    """The wrapper gives those zeros; a hunter that drops out and stays has its own observations, and rewards of zero.

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
