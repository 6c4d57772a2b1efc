"""What other libraries ask of the interfaces, each of it found wanting once by a client that did not run.

`make compat` trains with the libraries themselves (docs/compatibility.md).
"""

import numpy as np
import pytest
import supersuit
from pettingzoo.utils.wrappers import TerminateIllegalWrapper

import catch_arena
from catch_arena.errors import ActionError, ConfigError

MIXED = ("target", "velocity", "full", "target")


@pytest.mark.rule("R7.2")
@pytest.mark.parametrize("make", [catch_arena.parallel_env, catch_arena.env])
def test_r7_2_infos_hold_the_mask_alone_or_nothing_where_that_is_asked_for(make):
    """TorchRL, BenchMARL and AgileRL make arrays of infos, and take neither None nor dicts in them."""
    told = {}
    for infos in ("full", "mask", "none"):
        env = make(control=MIXED, max_cycles=5, infos=infos)
        env.reset(seed=3)
        step = {"target": 1, "velocity": [0.5, 0.1], "full": {"cmd_vel": [1.0, 0.0], "catch": 0}}
        actions = dict(zip(env.agents, map(step.get, MIXED), strict=True))
        if make is catch_arena.env:
            for action in actions.values():
                env.step(action)
            told[infos] = env.infos
        else:
            *_, told[infos] = env.step(actions)
        assert env.unwrapped.config.digest == catch_arena.scenario("standard", control=MIXED, max_cycles=5).digest

    assert told["none"] == {agent: {} for agent in told["full"]}
    assert len({id(info) for info in told["none"].values()}) == 4
    for agent, control in zip(told["full"], MIXED, strict=True):
        if control == "velocity":
            assert told["mask"][agent] == {}
            continue
        (mask,) = told["mask"][agent].values()
        full = told["full"][agent]["action_mask"]
        assert (mask == (full["catch"] if control == "full" else full)).all()
        assert (mask.dtype, mask.shape) == (np.int8, (9,))


def test_masks_that_are_told_alone_are_the_callers_own():
    """What is written into one changes nothing, and the next step does not change it."""
    env = catch_arena.parallel_env("scarce", infos="mask")
    _, infos = env.reset(seed=3)
    kept = infos["hunter_0"]["action_mask"].copy()
    for _ in range(100):
        env.step(dict.fromkeys(env.agents, 1))

    assert (infos["hunter_0"]["action_mask"] == kept).all()
    infos["hunter_0"]["action_mask"][:] = 0
    assert env.step(dict.fromkeys(env.agents, 1))[-1]["hunter_0"]["action_mask"][0] == 1


@pytest.mark.parametrize("infos", ["masks", None, True, ["mask"], np.array(["mask", "none"])])
def test_infos_of_an_unknown_kind_are_refused(infos):
    """With the kinds that there are."""
    for make in (catch_arena.parallel_env, catch_arena.env):
        with pytest.raises(ConfigError, match="infos must be one of full, mask, none, got"):
            make(infos=infos)


@pytest.mark.parametrize("action", [np.array([2]), np.array([[2]], dtype=np.uint8), np.int8(2), np.array(2)])
def test_an_integer_array_of_one_element_is_an_action(action):
    """A policy's answer to one row has the shape (1,)."""
    one, other = (catch_arena.parallel_env("duel", control=("target", "full")) for _ in range(2))
    for env, rank in ((one, action), (other, 2)):
        env.reset(seed=1)
        env.step({"hunter_0": rank, "hunter_1": {"cmd_vel": (1.0, 0.0), "catch": rank}})

    assert one.digest() == other.digest()


@pytest.mark.parametrize(
    "action", [2.0, np.array([2.0]), np.array([1, 2]), np.array([]), np.array([True]), np.bool_(1)]
)
def test_a_whole_float_two_elements_or_a_bool_is_no_action(action):
    """Adapters convert; a float is more often a slip."""
    env = catch_arena.parallel_env("duel")
    env.reset(seed=1)
    with pytest.raises(ActionError, match="hunter_0: an action must be a whole number from 0 to 8, got"):
        env.step({"hunter_0": action, "hunter_1": 0})


def test_np_random_follows_from_the_episodes_seed():
    """And the rules do not read it."""
    env = catch_arena.parallel_env("duel")
    env.reset(seed=5)
    digest, first = env.digest(), env.np_random.integers(1 << 40)
    assert env.digest() == digest
    env.reset()
    following = env.np_random.integers(1 << 40)
    env.reset(seed=5)

    assert env.np_random.integers(1 << 40) == first
    assert env.np_random.integers(1 << 40) not in (first, following)
    assert isinstance(catch_arena.parallel_env("duel").np_random, np.random.Generator)


@pytest.mark.parametrize("frames", [4, (2, 5)])
def test_supersuits_frame_skip_plays(frames):
    """It draws from `np_random`; every step of its own is some of ours, and rewards are summed."""
    plain = catch_arena.parallel_env("crowd", max_cycles=40)
    env = supersuit.frame_skip_v0(plain, frames)
    env.reset(seed=2)
    steps, total = [0], 0.0
    while env.agents:
        _, rewards, *_ = env.step(dict.fromkeys(env.agents, 1))
        total += sum(rewards.values())
        steps.append(plain.world().step)

    lengths = set(np.diff(steps[:-1]).tolist())
    assert lengths == {4} if frames == 4 else lengths == {2, 3, 4, 5}
    assert steps[-1] == 40
    assert total == sum(hunter.score for hunter in plain.world().hunters) > 0


def test_supersuits_frame_skip_plays_agent_by_agent():
    """Under AEC, where it takes one number only."""
    plain = catch_arena.env("duel", max_cycles=40)
    env = supersuit.frame_skip_v0(plain, 4)
    env.reset(seed=2)
    turns = 0
    for _ in env.agent_iter():
        *_, terminated, truncated, _ = env.last()
        turns += not (terminated or truncated)
        env.step(None if terminated or truncated else 1)

    assert plain.world().step == 40
    assert turns == 20


def test_supersuits_black_death_asks_for_one_empty_step_after_the_end():
    """And gets five empty dicts; the wrapper then ends too."""
    plain = catch_arena.parallel_env("duel", max_cycles=3)
    env = supersuit.black_death_v3(plain)
    env.reset(seed=1)
    steps = 0
    while env.agents:
        *_, infos = env.step(dict.fromkeys(env.agents, 0))
        steps += 1

    assert (steps, infos) == (4, {agent: {} for agent in plain.possible_agents})
    assert plain.world().step == 3


def test_pettingzoos_wrapper_ends_an_episode_at_an_illegal_action():
    """TerminateIllegalWrapper writes into `unwrapped`; the next episode knows nothing of it."""
    for mask_in_observation in (False, True):
        plain = catch_arena.env("duel", mask_in_observation=mask_in_observation, initial_targets=0, max_targets=8)
        env = TerminateIllegalWrapper(plain, illegal_reward=-1)
        for _ in range(2):
            env.reset(seed=1)
            env.step(0)
            env.step(0)
            assert env.agent_selection == "hunter_0"
            env.step(5)  # there is no target yet
            ends = {}
            for agent in env.agent_iter():
                _, reward, terminated, truncated, _ = env.last()
                ends[agent] = (reward, terminated, truncated)
                env.step(None)
            assert ends == {"hunter_0": (-1.0, True, True), "hunter_1": (0, True, True)}


def test_a_time_limit_is_told_to_stable_baselines3():
    """`TimeLimit.truncated` stands where an episode is truncated, and nowhere else: SuperSuit lays the next reset's
    infos over the last step's.
    """
    env = catch_arena.parallel_env("duel", max_cycles=3)
    batch = supersuit.pettingzoo_env_to_vec_env_v1(catch_arena.parallel_env("duel", max_cycles=3))
    _, infos = env.reset(seed=1)
    batch.reset(seed=1)
    for step in range(3):
        assert not any("TimeLimit.truncated" in info for info in infos.values())
        observations, *_, infos = env.step(dict.fromkeys(env.agents, 1))
        *_, told = batch.step(np.array([1, 1]))
        assert any("TimeLimit.truncated" in info for info in told) == (step == 2)
    assert all(info["TimeLimit.truncated"] for info in infos.values())
    for info, observation in zip(told, observations.values(), strict=True):
        assert info["TimeLimit.truncated"] is True
        assert (info["terminal_observation"] == observation).all()


def test_who_is_terminated_in_the_last_step_is_not_told_of_a_time_limit():
    """R1.6, R1.7: one that was withdrawn ends by that; and an arena without targets left ends by itself."""
    env = catch_arena.parallel_env("duel", max_cycles=1)
    env.reset(seed=1)
    env.withdraw("hunter_0")
    *_, infos = env.step({"hunter_0": 0, "hunter_1": 0})
    assert ["TimeLimit.truncated" in info for info in infos.values()] == [False, True]

    env = catch_arena.parallel_env("duel", initial_targets=1, target_budget=1, reach_m=100.0)
    env.reset(seed=1)
    _, _, terminations, _, infos = env.step({"hunter_0": 1, "hunter_1": 1})
    assert all(terminations.values())
    assert not any("TimeLimit.truncated" in info for info in infos.values())
