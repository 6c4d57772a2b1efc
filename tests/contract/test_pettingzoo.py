"""PettingZoo's own tests, in every control, and what they leave out."""

import hashlib
import warnings

import cv2
import numpy as np
import pettingzoo
import pytest
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, render_test
from pettingzoo.test.max_cycles_test import max_cycles_test
from pettingzoo.test.state_test import test_parallel_env as state_test
from pettingzoo.utils.wrappers.record_video_parallel import RecordVideoParallel

import catch_arena
import catch_arena.envs

CONTROLS = ["target", "velocity", "full", ("target", "velocity", "full", "target")]

# what PettingZoo says of any Dict action space, and of seats that differ
KNOWN = (
    "ignore:Action space for each agent probably should be",
    "ignore:The class of observation spaces is different",
    "ignore:Agents have different observation space",
    "ignore:Observation is not a NumPy array",
    "ignore:Observation space for each agent probably should be",
)
known_remarks = [pytest.mark.filterwarnings(remark) for remark in KNOWN]


@pytest.mark.parametrize("control", CONTROLS, ids=str)
def test_the_parallel_env_passes_pettingzoos_tests(control):
    """API and seeds, warnings being errors."""
    parallel_api_test(catch_arena.parallel_env(control=control, max_cycles=60), num_cycles=150)
    parallel_seed_test(lambda: catch_arena.parallel_env(control=control), num_cycles=20)


@pytest.mark.parametrize("control", CONTROLS, ids=str)
@pytest.mark.parametrize("mask_in_observation", [False, True])
def test_the_aec_env_passes_pettingzoos_test(control, mask_in_observation):
    """Warnings are errors, except the remarks on kinds of spaces that PettingZoo makes of its own environments too."""
    with warnings.catch_warnings():
        for remark in KNOWN:
            warnings.filterwarnings("ignore", message=remark.split(":", 1)[1])
        api_test(
            catch_arena.env(control=control, max_cycles=30, mask_in_observation=mask_in_observation), num_cycles=200
        )


def test_a_mask_in_the_observation_is_used_by_pettingzoo():
    """Sampling by the mask never names a rank without a target."""
    env = catch_arena.parallel_env("scarce", mask_in_observation=True, max_cycles=200)
    parallel_api_test(env, num_cycles=50)
    observations, infos = env.reset(seed=5)
    while env.agents:
        actions = {a: env.action_space(a).sample(observations[a]["action_mask"]) for a in env.agents}
        observations, *_, infos = env.step(actions)
        for agent, info in infos.items():
            assert info["verdict"] != catch_arena.Verdict.MALFORMED
            if agent in observations:
                assert (info["action_mask"] == observations[agent]["action_mask"]).all()


class _Module:
    """max_cycles_test wants a module."""

    env = staticmethod(catch_arena.env)
    parallel_env = staticmethod(catch_arena.parallel_env)


def test_max_cycles_is_obeyed():
    """PettingZoo's test, and ours: exactly so many steps."""
    max_cycles_test(_Module)
    env = catch_arena.parallel_env(max_cycles=7)
    env.reset(seed=1)
    steps = 0
    while env.agents:
        *_, truncations, _ = env.step(dict.fromkeys(env.agents, 0))
        steps += 1

    assert steps == 7
    assert all(truncations.values())


def test_rendering_passes_pettingzoos_test():
    """Frames under rgb_array in both APIs."""
    render_test(lambda render_mode: catch_arena.env(render_mode=render_mode, max_cycles=5))


def test_state_passes_pettingzoos_test():
    """`state` lies in `state_space` over an episode."""
    env = catch_arena.parallel_env(max_cycles=50)
    state_test(env)
    env.reset(seed=3)
    while env.agents:
        state = env.state()
        assert env.state_space.contains(state)
        env.step({agent: env.action_space(agent).sample() for agent in env.agents})


@pytest.mark.parametrize("name", list(catch_arena.SCENARIOS))
def test_observations_lie_in_their_space_for_whole_episodes(name):
    """Every scenario, in a mix of controls where there are enough seats."""
    hunters = catch_arena.scenario(name).hunters
    control = tuple(("target", "velocity", "full")[seat % 3] for seat in range(hunters))
    env = catch_arena.parallel_env(name, control=control, reverse=True)
    observations, _ = env.reset(seed=11)
    rng = np.random.default_rng(4)
    for agent in env.agents:
        env.action_space(agent).seed(int(rng.integers(1 << 30)))
    while env.agents:
        for agent, observation in observations.items():
            assert env.observation_space(agent).contains(observation), agent
        observations, *_ = env.step({agent: env.action_space(agent).sample() for agent in env.agents})


def episode_hash(make, seed):
    """A hash over everything that a whole episode delivers."""
    env = make()
    digest = hashlib.blake2b()
    observations, infos = env.reset(seed=seed)
    for index, agent in enumerate(env.possible_agents):
        env.action_space(agent).seed(index)
    while env.agents:
        results = env.step({agent: env.action_space(agent).sample() for agent in env.agents})
        observations, rewards, terminations, truncations, infos = results
        digest.update(repr((rewards, terminations, truncations)).encode())
        for agent in observations:
            digest.update(observations[agent].tobytes())
            info = {k: v for k, v in infos[agent].items() if k != "action_mask"}
            digest.update(repr(info).encode())
        digest.update(env.digest())
    return digest.hexdigest()


@pytest.mark.parametrize("control", CONTROLS, ids=str)
def test_whole_episodes_repeat_by_their_seed(control):
    """PettingZoo's seed test looks at one step; this one at all of them, and at a second reset of the same env."""

    def make():
        return catch_arena.parallel_env("faulty", control=control, max_cycles=200)

    first = episode_hash(make, 77)

    assert first == episode_hash(make, 77)
    assert first != episode_hash(make, 78)


def test_resets_without_a_seed_follow_from_the_first_seed():
    """A run of episodes is repeated by its first seed, and its episodes differ."""

    def digests():
        env = catch_arena.parallel_env()
        found = []
        env.reset(seed=9)
        for _ in range(3):
            found.append(env.digest())
            env.reset()
        return found

    first = digests()

    assert first == digests()
    assert len(set(first)) == 3


@pytest.mark.parametrize("api", ["parallel", "aec"])
def test_pettingzoo_makes_every_scenario(api):
    """The registry serves third parties."""
    for name in catch_arena.SCENARIOS:
        env = pettingzoo.make(api, f"catch_arena/{name}_v1", max_cycles=3)
        env.reset(seed=1)
        assert env.unwrapped.config == catch_arena.scenario(name, max_cycles=3)


def test_aec_and_parallel_play_the_same_match():
    """The same actions by either interface: the same digests, rewards and observations."""
    parallel, aec = catch_arena.parallel_env(max_cycles=100), catch_arena.env(max_cycles=100)
    parallel.reset(seed=4)
    aec.reset(seed=4)
    rng = np.random.default_rng(0)
    while parallel.agents:
        actions = {agent: int(rng.integers(0, 9)) for agent in parallel.agents}
        observations, rewards, *_ = parallel.step(actions)
        for agent in list(actions):
            assert aec.agent_selection == agent
            aec.step(actions[agent])
        for agent in actions:
            assert (aec.observe(agent) == observations[agent]).all()
            assert aec.rewards[agent] == rewards[agent]
        assert aec.unwrapped.digest() == parallel.digest()


def test_observations_and_masks_are_the_callers_own():
    """What a step delivered does not change with the next step, nor the arena with what is written into it."""
    env = catch_arena.parallel_env()
    observations, infos = env.reset(seed=1)
    kept = observations["hunter_0"].copy()
    env.step(dict.fromkeys(env.agents, 1))

    assert (observations["hunter_0"] == kept).all()

    other = catch_arena.parallel_env()
    observations, infos = other.reset(seed=1)
    observations["hunter_0"][:] = 7
    infos["hunter_0"]["action_mask"][:] = 0
    other.step(dict.fromkeys(other.agents, 1))

    assert other.digest() == env.digest()


@pytest.mark.extras
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # its own
def test_pettingzoos_recorder_films_the_env(tmp_path):
    """RecordVideoParallel writes a video of an episode; ours is `catch-arena render`, which drops no frame."""
    env = RecordVideoParallel(
        catch_arena.parallel_env(render_mode="rgb_array", max_cycles=12),
        str(tmp_path / "videos"),
        episode_trigger=lambda _: True,
    )
    env.reset(seed=1)
    while env.agents:
        env.step(dict.fromkeys(env.agents, 1))
    env.close()
    (video,) = tmp_path.glob("videos/*.mp4")
    frames = cv2.VideoCapture(str(video))

    assert frames.isOpened()
    assert int(frames.get(cv2.CAP_PROP_FRAME_COUNT)) >= 12
    assert (frames.get(cv2.CAP_PROP_FRAME_WIDTH), frames.get(cv2.CAP_PROP_FPS)) == (500.0, 10.0)
