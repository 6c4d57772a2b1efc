"""Every kind of environment passes PettingZoo's own tests, and tests of what those leave out."""

import json

import cv2
import numpy as np
import pettingzoo
import pytest
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, render_test
from pettingzoo.test.max_cycles_test import max_cycles_test
from pettingzoo.test.state_test import test_parallel_env as state_test
from pettingzoo.utils.wrappers.record_video_parallel import RecordVideoParallel

import catch_arena
import catch_arena.envs.registration

CONTROLS = ["target", "velocity", "full", ("target", "velocity", "full", "target")]


KINDS = [
    *({"control": control} for control in CONTROLS),
    *({"control": control, "mask_in_observation": True} for control in CONTROLS),
    *({"dropout_rate": 0.05, "dropouts": dropouts} for dropouts in ("leave", "fixed")),
    *({"env": "tag", "prey_returns_s": returns, "reach_m": 2.0} for returns in (0.0, 0.5, None)),
    *({"env": name} for name in catch_arena.SCENARIOS),
]
"""A scenario and settings of each kind of agents."""


@pytest.mark.filterwarnings(  # PettingZoo's remarks on Dict spaces, and on agents that differ
    "ignore:Action space for each agent",
    "ignore:The class of observation spaces is different",
    "ignore:Agents have different observation space",
    "ignore:Observation is not a NumPy array",
    "ignore:Observation space for each agent probably should be",
    "ignore:Observations are different shapes",
)
@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_both_envs_pass_pettingzoos_tests(kind):
    """API, AEC and seeds; other warnings are errors."""
    name, settings = kind.get("env", "standard"), {key: value for key, value in kind.items() if key != "env"}
    parallel_api_test(catch_arena.parallel_env(name, max_cycles=40, **settings), num_cycles=80)
    if "mask_in_observation" not in settings:
        parallel_seed_test(lambda: catch_arena.parallel_env(name, **settings), num_cycles=20)
    api_test(catch_arena.env(name, max_cycles=25, **settings), num_cycles=100)


@pytest.mark.rule("R1.7", "R12.3")
@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("standard", {}),
        ("dropout", {"dropout_rate": 0.05, "dropouts": "leave"}),
        ("dropout", {"dropout_rate": 0.05, "dropouts": "fixed"}),
        ("tag", {"prey_returns_s": 0.5, "reach_m": 1.0}),
        ("tag", {"prey_returns_s": None, "reach_m": 1.0}),
    ],
)
def test_r1_7_agent_by_agent_the_same_match_is_played(name, settings):
    """AEC: whoever has left is asked for one last action, None, and then no more."""
    one, other = (make(name, max_cycles=30, **settings) for make in (catch_arena.parallel_env, catch_arena.env))
    for seed in range(3):
        one.reset(seed=seed)
        other.reset(seed=seed)
        gone = set()
        while one.agents:
            chosen = {agent: 1 if one.action_space(agent).shape == () else np.array([0.5, 0.3]) for agent in one.agents}
            observations, rewards, *_ = one.step(chosen)
            for agent, action in chosen.items():
                while other.agent_selection != agent:  # those that have left stand before it
                    gone.add(other.agent_selection)
                    other.step(None)
                other.step(action)
            assert other.unwrapped.digest() == one.digest()
            for agent in chosen:
                assert (other.observe(agent) == observations[agent]).all()
                assert other.rewards[agent] == rewards[agent]
        for agent in other.agent_iter():
            gone.add(agent)
            other.step(None)
        assert gone == set(other.possible_agents)


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


def test_rendering_passes_pettingzoos_test(monkeypatch):
    """Frames under rgb_array, and a window on a display that SDL makes up."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
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


@pytest.mark.parametrize("api", ["parallel", "aec"])
def test_pettingzoo_makes_every_scenario(api):
    """The registry serves third parties."""
    for name in catch_arena.SCENARIOS:
        env = pettingzoo.make(api, f"catch_arena/{name}_v1", max_cycles=3)
        env.reset(seed=1)
        assert env.unwrapped.config == catch_arena.scenario(name, max_cycles=3)


def test_observations_and_masks_are_the_callers_own():
    """Later steps change nothing that was returned, and writing into it changes no arena."""
    env, other = catch_arena.parallel_env("crowd"), catch_arena.parallel_env("crowd")
    results, seen = [env.reset(seed=1)], []
    observations, infos = other.reset(seed=1)
    for _ in range(60):
        seen.append(as_text(results[-1]))
        results.append(env.step(dict.fromkeys(env.agents, 1)))
        observations["hunter_0"][:] = 7
        infos["hunter_0"]["action_mask"][:] = 0
        observations, *_, infos = other.step(dict.fromkeys(other.agents, 1))

    assert list(map(as_text, results[:-1])) == seen
    assert len(set(seen)) == 60
    assert other.digest() == env.digest()


def as_text(results):
    return json.dumps(results, default=lambda array: array.tolist())


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
