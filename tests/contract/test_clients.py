"""The environments give other libraries the infos, names, spaces and seeds that these ask for.

`make compat` trains with the libraries themselves (docs/reference/compatibility.md).
"""

import re
import warnings
from io import BytesIO

import numpy as np
import pytest
import supersuit
from gymnasium import spaces
from pettingzoo.test import api_test
from pettingzoo.utils.wrappers import TerminateIllegalWrapper

import catch_arena
from catch_arena.errors import ActionError, ConfigError

MIXED = ("target", "velocity", "full", "target")


@pytest.mark.rule("R7.2")
@pytest.mark.parametrize("make", [catch_arena.parallel_env, catch_arena.env])
def test_r7_2_infos_hold_the_mask_alone_or_nothing_where_that_is_asked_for(make):
    """Nothing else of the arena depends on `infos`."""
    results = {}
    for infos in ("full", "mask", "none"):
        env = make(control=MIXED, max_cycles=5, infos=infos)
        env.reset(seed=3)
        step = {"target": 1, "velocity": [0.5, 0.1], "full": {"cmd_vel": [1.0, 0.0], "catch": 0}}
        actions = dict(zip(env.agents, map(step.get, MIXED), strict=True))
        if make is catch_arena.env:
            for action in actions.values():
                env.step(action)
            results[infos] = env.infos
        else:
            *_, results[infos] = env.step(actions)
        assert env.unwrapped.config.digest == catch_arena.scenario("standard", control=MIXED, max_cycles=5).digest

    assert results["none"] == {agent: {} for agent in results["full"]}
    assert len({id(info) for info in results["none"].values()}) == 4
    for agent, control in zip(results["full"], MIXED, strict=True):
        if control == "velocity":
            assert results["mask"][agent] == {}
            continue
        (mask,) = results["mask"][agent].values()
        assert (mask == results["full"][agent]["action_mask"]).all()
        assert (mask.dtype, mask.shape) == (np.int8, (9,))


EVERYTHING = {"control": ("target", "full", "target"), "teams": ((0, 1), (2,)), "dropout_rate": 0.05}
EVERY_KEY = {
    "verdict",
    "target",
    "distance_um",
    "winner",
    "reward_parts",
    "action_mask",
    "TimeLimit.truncated",
}


@pytest.mark.rule("R7.2")
@pytest.mark.parametrize("make", [catch_arena.parallel_env, catch_arena.env])
@pytest.mark.parametrize(
    ("scenario", "settings", "keys", "keys_of_prey"),
    [
        ("standard", {}, EVERY_KEY, None),
        ("duel", {"control": "velocity"}, EVERY_KEY - {"action_mask"}, None),
        (
            "tag",
            {**EVERYTHING, "dropouts": "fixed", "reach_m": 20.0},
            EVERY_KEY | {"team_score", "active"},
            {"active", "caught_by", "reward_parts", "TimeLimit.truncated"},
        ),
    ],
)
def test_r7_2_infos_hold_numbers_and_arrays_of_one_type_each(make, scenario, settings, keys, keys_of_prey):
    """Replay buffers and tensors are made of them: no None, no text, no dict, for every agent and step."""
    env = make(scenario, max_cycles=40, **settings)
    kinds = {}
    for seed in range(2):
        for agent, info in steps_of(env, seed):
            assert set(info) == (keys_of_prey if agent.startswith("prey") else keys)
            for key, value in info.items():
                assert isinstance(value, int | np.ndarray)
                array = np.asarray(value)
                kinds.setdefault((agent[:5], key), set()).add((type(value), array.dtype, array.shape))
    assert {name: len(found) for name, found in kinds.items()} == dict.fromkeys(kinds, 1)


def steps_of(env, seed):
    """Each agent's info of each step of an episode, while hunters go for the nearest target, and of its reset."""
    begun = env.reset(seed=seed)
    yield from (begun[1] if begun else env.infos).items()
    rest = np.zeros(2, np.float32)
    actions = {
        agent: space.sample() if agent.startswith("prey") or not isinstance(space, spaces.Discrete) else 1
        for agent, space in ((agent, env.action_space(agent)) for agent in env.possible_agents)
    }
    actions |= {agent: {"cmd_vel": rest, "catch": 1} for agent, action in actions.items() if isinstance(action, dict)}
    if hasattr(env, "agent_iter"):
        for agent in env.agent_iter():
            *_, terminated, truncated, info = env.last()
            yield agent, info
            env.step(None if terminated or truncated else actions[agent])
        return
    while env.agents:
        *_, infos = env.step({agent: actions[agent] for agent in env.agents})
        yield from infos.items()


def test_an_info_has_the_ruling_in_numbers():
    """Two hunters ask for one target, and one for nothing."""
    env = catch_arena.parallel_env(
        hunters=3, initial_targets=1, max_targets=1, spawning=False, reach_m=20.0, max_cycles=1
    )
    env.reset(seed=1)
    *_, infos = env.step({"hunter_0": 1, "hunter_1": 1, "hunter_2": 0})
    rulings = env.world().rulings
    assert {ruling.verdict.name for ruling in rulings} == {"GRANTED", "LOST_CONTEST"}
    for ruling in rulings:
        info = infos[f"hunter_{ruling.hunter}"]
        assert info["verdict"] == ruling.verdict
        assert (info["target"], info["distance_um"], info["winner"]) == (1, ruling.distance_um, ruling.winner)
    none = infos["hunter_2"]
    assert (none["verdict"], none["target"], none["distance_um"], none["winner"]) == (0, -1, -1, -1)


@pytest.mark.parametrize("names", [None, "agent_{seat}", ["adversary_0", "adversary_1", "adversary_2", "agent_0"]])
def test_the_two_dictionaries_of_spaces_hold_each_agents_space(names):
    """PettingZoo documents both; the same objects as by the methods, so that a seed of theirs counts."""
    for make in (catch_arena.parallel_env, catch_arena.env):
        env = make("tag", agent_names=names)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # PettingZoo's remark under AEC, that the methods are preferred
            seen, done = env.observation_spaces, env.action_spaces
        assert list(seen) == list(done) == env.possible_agents
        for agent in env.possible_agents:
            assert seen[agent] is env.observation_space(agent)
            assert done[agent] is env.action_space(agent)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("agent_{seat}", ["agent_0", "agent_1", "agent_2", "agent_3"]),
        (["adversary_0", "adversary_1", "adversary_2", "agent_0"],) * 2,
        (("a", "b", "hunter_0", "prey_0"), ["a", "b", "hunter_0", "prey_0"]),
        (np.array(["a", "b", "c", "d"]), ["a", "b", "c", "d"]),
        ("agent_{seat:02d}", ["agent_00", "agent_01", "agent_02", "agent_03"]),
    ],
)
def test_agents_may_have_other_names_and_nothing_else_changes(given, expected):
    """Not the digests, the world or the replay; prey's seats follow the hunters'."""
    usual = catch_arena.parallel_env("tag", max_cycles=30)
    renamed = catch_arena.parallel_env("tag", max_cycles=30, agent_names=given)
    assert renamed.possible_agents == expected
    assert renamed.config == usual.config
    results = []
    for env in (usual, renamed):
        env.record()
        results.append([env.reset(seed=3)])
    while usual.agents:
        for env, steps in zip((usual, renamed), results, strict=True):
            steps.append(env.step(dict.fromkeys(env.agents, np.array([1.0, 0.3], np.float32))))
        assert usual.digest() == renamed.digest()
        assert usual.world() == renamed.world()
    files = [BytesIO(), BytesIO()]
    for env, file in zip((usual, renamed), files, strict=True):
        env.replay().save(file)
    assert files[0].getvalue() == files[1].getvalue()
    for one, other in zip(*results, strict=True):
        for mine, theirs in zip(one, other, strict=True):
            assert list(theirs) == expected
            assert repr(list(mine.values())) == repr(list(theirs.values()))
    with pytest.raises(ActionError, match="unknown agent 'hunter_1'"):
        renamed.action_space("hunter_1")


def test_an_aec_env_may_have_other_names():
    """PettingZoo's own test, and its turns."""
    env = catch_arena.env("duel", agent_names="agent_{seat}", max_cycles=20)
    api_test(env, num_cycles=50)
    env.reset(seed=1)
    assert env.agent_selection == "agent_0"
    env.step(1)
    env.restore(env.save())
    assert env.agent_selection == "agent_1"
    env.withdraw("agent_0")


@pytest.mark.parametrize("names", ["agent", ["a", 2], "{seat:x!}", "{seat[0]}", "{seat}{other}", 7, ["a"], ["a", "a"]])
def test_names_that_agents_cannot_have_are_refused(names):
    """By both envs."""
    for make in (catch_arena.parallel_env, catch_arena.env):
        with pytest.raises(ConfigError, match=f"^agent_names must be .*, got {re.escape(repr(names))}"):
            make("duel", agent_names=names)
    with pytest.raises(ConfigError, match="agent_names must be a pattern"):
        catch_arena.parallel_env("standard", hunters=1, agent_names="bob")


def test_continuous_actions_stand_for_velocity_control():
    """MPE's word; False is the discrete control, where the scenario would have the other."""
    for continuous, control in ((True, "velocity"), (False, "target")):
        for name in ("standard", "tag"):
            assert catch_arena.parallel_env(name, continuous_actions=continuous).config == catch_arena.scenario(
                name, control=control
            )
    assert catch_arena.VectorArena("duel", 2, continuous_actions=True).config.control == "velocity"
    with pytest.raises(ConfigError, match="continuous_actions must be True or False, got 'yes'"):
        catch_arena.env(continuous_actions="yes")
    with pytest.raises(ConfigError, match="control and continuous_actions must not both be given"):
        catch_arena.env(continuous_actions=True, control="full")


@pytest.mark.parametrize("infos", ["masks", None, True, ["mask"], np.array(["mask", "none"])])
def test_infos_of_an_unknown_kind_are_refused(infos):
    """With the kinds that there are."""
    for make in (catch_arena.parallel_env, catch_arena.env):
        with pytest.raises(ConfigError, match="infos must be one of full, mask, none, got"):
            make(infos=infos)


def test_np_random_follows_from_the_episodes_seed():
    """The rules do not read it."""
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
    """The wrapper draws from `np_random`; each of its steps is several of ours, and rewards are summed."""
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
    """By `TimeLimit.truncated`; the next reset tells it again, for SuperSuit lays its infos over the last step's."""
    env = catch_arena.parallel_env("duel", max_cycles=3)
    batch = supersuit.pettingzoo_env_to_vec_env_v1(catch_arena.parallel_env("duel", max_cycles=3))
    _, infos = env.reset(seed=1)
    batch.reset(seed=1)
    for step in range(3):
        assert not any(info["TimeLimit.truncated"] for info in infos.values())
        observations, *_, infos = env.step(dict.fromkeys(env.agents, 1))
        *_, batch_infos = batch.step(np.array([1, 1]))
        assert any(info["TimeLimit.truncated"] for info in batch_infos) == (step == 2)
    assert all(info["TimeLimit.truncated"] for info in infos.values())
    for info, observation in zip(batch_infos, observations.values(), strict=True):
        assert info["TimeLimit.truncated"] is True
        assert (info["terminal_observation"] == observation).all()
    for seed, expected in ((None, True), (None, False), (1, False)):
        assert all(info["TimeLimit.truncated"] is expected for info in env.reset(seed=seed)[1].values())


def test_who_is_terminated_in_the_last_step_is_not_told_of_a_time_limit():
    """R1.6, R1.7: one that was withdrawn ends by that; and an arena without targets left ends by itself."""
    env = catch_arena.parallel_env("duel", max_cycles=1)
    env.reset(seed=1)
    env.withdraw("hunter_0")
    *_, infos = env.step({"hunter_0": 0, "hunter_1": 0})
    assert [info["TimeLimit.truncated"] for info in infos.values()] == [False, True]
    assert [info["TimeLimit.truncated"] for info in env.reset()[1].values()] == [False, True]

    env = catch_arena.parallel_env("duel", initial_targets=1, target_budget=1, reach_m=100.0)
    env.reset(seed=1)
    _, _, terminations, _, infos = env.step({"hunter_0": 1, "hunter_1": 1})
    assert all(terminations.values())
    assert not any(info["TimeLimit.truncated"] for info in infos.values())
    assert not any(info["TimeLimit.truncated"] for info in env.reset()[1].values())
