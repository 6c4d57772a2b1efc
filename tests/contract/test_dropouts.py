"""R1.7 in every interface: hunters that drop out leave, or stay and do nothing."""

import numpy as np
import pytest
import supersuit
from contract.episodes import chased

import catch_arena
from catch_arena.errors import ActionError
from catch_arena.verdicts import Verdict

RATE = 0.02


@pytest.mark.rule("R1.7")
def test_r1_7_who_drops_out_is_terminated_in_that_step_and_leaves():
    """With a last observation, and never truncated too; the state says that it is withdrawn."""
    left = 0
    for seed in range(6):
        env = catch_arena.parallel_env(dropout_rate=RATE, max_cycles=40)
        for agents, (observations, _, terminations, truncations, _) in chased(env, seed):
            assert set(observations) == set(terminations) == set(agents)
            withdrawn = {hunter.name for hunter in env.world().hunters if hunter.withdrawn}
            assert {agent for agent in agents if terminations[agent]} == withdrawn & set(agents)
            assert not any(terminations[agent] and truncations[agent] for agent in agents)
            left += sum(terminations.values())
            if env.agents:
                assert set(env.agents) == set(agents) - withdrawn
    assert left > 6


@pytest.mark.rule("R1.7")
def test_r1_7_who_drops_out_and_stays_is_refused_and_told_apart_by_active():
    """The hunter goes on to act, to see and to have a mask; no agent is terminated."""
    refused = 0
    env = catch_arena.parallel_env(dropout_rate=RATE, dropouts="fixed", max_cycles=60, control="full")
    observations, infos = env.reset(seed=3)
    assert all(info["active"] for info in infos.values())
    while env.agents:
        actions = {agent: {"cmd_vel": np.ones(2, np.float32), "catch": 1} for agent in env.agents}
        actions = {
            agent: action if infos[agent]["action_mask"][1] else action | {"catch": 0}
            for agent, action in actions.items()
        }
        observations, _, terminations, _, infos = env.step(actions)
        assert list(observations) == env.possible_agents
        assert not any(terminations.values())
        for hunter in env.world().hunters:
            assert infos[hunter.name]["active"] is not hunter.withdrawn
            if hunter.withdrawn and actions[hunter.name]["catch"]:
                assert infos[hunter.name]["verdict"] == Verdict.HUNTER_INACTIVE
                refused += 1
    assert refused > 20


@pytest.mark.rule("R1.7")
@pytest.mark.parametrize("dropouts", ["leave", "fixed"])
def test_r1_7_both_ways_play_the_same_arena(dropouts):
    """The interface differs, not the game: the batch of arrays has the same states, and says who is active."""
    config = catch_arena.scenario("standard", dropout_rate=RATE, dropouts=dropouts, max_cycles=30)
    env, batch = catch_arena.parallel_env(config), catch_arena.VectorArena(config, 3, auto_reset=False)
    env.reset(seed=11)
    _, batch_infos = batch.reset(seed=[5, 11, 7])
    assert batch_infos["active"].all()
    while env.agents:
        env_actions = dict.fromkeys(env.agents, 1)
        _, _, _, _, batch_infos = batch.step(np.ones((3, 4), dtype=np.int64))
        env.step(env_actions)
        # who has left gives no action, and a withdrawn hunter's is refused: the same
        assert env.digest() == batch.digest(1)
        assert batch_infos["active"][1].tolist() == [not hunter.withdrawn for hunter in env.world().hunters]
    assert any(hunter.withdrawn for hunter in env.world().hunters)


@pytest.mark.rule("R1.7")
def test_r1_7_a_batch_without_dropouts_says_nothing_of_them():
    assert "active" not in catch_arena.VectorArena("standard", 2).reset(seed=1)[1]
    assert "active" not in next(iter(catch_arena.parallel_env().reset(seed=1)[1].values()))


@pytest.mark.rule("R1.7")
def test_r1_7_a_match_of_dropouts_has_no_forfeits():
    """Score and rank stay; who has left is not asked any more."""
    from catch_arena.agents.nearest import Agent
    from catch_arena.tournament.match_loop import play_match

    class Counting(Agent):
        calls = 0

        def act(self, view):
            self.calls += 1
            return super().act(view)

    config = catch_arena.scenario("standard", dropout_rate=RATE, max_cycles=60)
    dropped_out = 0
    for seed in range(4):
        players = [Counting() for _ in range(4)]
        worlds = []
        result = play_match(
            config, seed, players, list("abcd"), watch=lambda env, seen=worlds: seen.append(env.world())
        )
        for seat, player in enumerate(players):
            assert player.calls == sum(not world.hunters[seat].withdrawn for world in worlds[:-1])
            dropped_out += worlds[-1].hunters[seat].withdrawn
        assert result.forfeit_codes == (None,) * 4
        assert min(result.ranks) == 1
        best = max(result.scores)
        assert all((rank == 1) == (score == best) for rank, score in zip(result.ranks, result.scores, strict=True))
    assert dropped_out > 4


@pytest.mark.parametrize("action", [1, "any"])
def test_actions_of_agents_that_have_left_are_ignored(action):
    """TorchRL and SuperSuit give one for each possible agent; after a restore too. Unknown names and missing actions
    are refused as before.
    """
    env, other = (catch_arena.parallel_env(dropout_rate=RATE, max_cycles=600) for _ in range(2))
    for one in (env, other):
        one.reset(seed=2)
        one.withdraw("hunter_0")
    while len(env.agents) > 1:
        env.step(dict.fromkeys(env.possible_agents, action) | dict.fromkeys(env.agents, 1))
        other.step(dict.fromkeys(other.agents, 1))
        assert env.agents == other.agents
        assert env.digest() == other.digest()
        env.restore(env.save())
    (last,) = env.agents
    with pytest.raises(ActionError, match="unknown agent 'hunter_9'"):
        env.step({last: 1, "hunter_9": 1})
    with pytest.raises(ActionError, match=f"actions must have an action for each agent, got none for {last}"):
        env.step(dict.fromkeys(set(env.possible_agents) - {last}, 1))
    assert env.digest() == other.digest()


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
