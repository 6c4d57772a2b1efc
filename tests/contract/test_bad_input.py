"""Bad calls are refused by an error that names field, requirement and value, and leave the arena as it was."""

import re

import numpy as np
import pytest

import catch_arena
from catch_arena.errors import (
    ActionError,
    CatchArenaError,
    ConfigError,
    EpisodeError,
)
from catch_arena.explanation import step_at
from catch_arena.layout import prey_columns, state_columns

TEAMS = "teams must name each seat from 0 to 3 once, and each team must have a seat, got (("
NAN = float("nan")
INFINITY = float("inf")

BAD_CONFIGS = [
    ({"reach_m": -0.3}, "reach_m must be above 0 and at most 10000, got -0.3"),
    ({"reach_m": NAN}, "reach_m must be above 0 and at most 10000, got nan"),
    ({"hunters": 0}, "hunters must be a whole number from 1 to 64, got 0"),
    ({"hunters": 2.5}, "hunters must be a whole number from 1 to 64, got 2.5"),
    ({"observed_targets": 17}, "observed_targets must be a whole number from 1 to 16 (max_targets), got 17"),
    ({"initial_targets": 17}, "initial_targets must be a whole number from 0 to 16 (max_targets), got 17"),
    ({"control_period_ms": 15}, "control_period_ms must be a whole number from 16"),
    ({"time_limit_s": 0}, "time_limit_s must be above 0"),
    ({"max_cycles": 0}, "max_cycles must be a whole number from 1"),
    ({"control": "telepathy"}, "control must be one of target, velocity, full, got 'telepathy'"),
    ({"control": ("target",)}, "control must be one value, or one for each of 4 hunters, got ('target',)"),
    ({"policy": "nearst"}, "policy must be one of nearest, first_come, capstone, got 'nearst'"),
    ({"target_motion": "run"}, "target_motion must be one of still, wander, flee, got 'run'"),
    ({"target_speed_mps": INFINITY}, "target_speed_mps must be above 0 and at most 1000, got inf"),
    ({"wander_period_ms": 0}, "wander_period_ms must be a whole number from 1 to 1000000000, got 0"),
    ({"alarm_m": -0.1}, "alarm_m must be at least 0 and at most 10000, got -0.1"),
    ({"max_speed_mps": INFINITY}, "max_speed_mps must be above 0 and at most 1000, got inf"),
    ({"max_speed_mps": (2.0, 1.0)}, "max_speed_mps must be one value, or one for each of 4 hunters, got (2.0, 1.0)"),
    (
        {"max_turn_rate_radps": (4.0, 4.0, INFINITY, 4.0)},
        "max_turn_rate_radps[2] must be above 0 and at most 1000",
    ),
    ({"reach_m": (0.3, 0.3, 0.3, 0.0)}, "reach_m[3] must be above 0 and at most 10000, got 0.0"),
    ({"view_radius_m": 0}, "view_radius_m must be above 0 and at most 10000, got 0"),
    ({"alarm_m": 10**400}, "alarm_m must be at least 0 and at most 10000, got 1000"),
    ({"view_angle_deg": 400}, "view_angle_deg must be above 0 and at most 360, got 400"),
    ({"view_noise_m": -1e-9}, "view_noise_m must be at least 0 and at most 1000, got -1e-09"),
    ({"policy": "capstone", "view_radius_m": 3.0}, "view_radius_m must be None under the policy 'capstone', got 3.0"),
    ({"policy": "capstone", "view_angle_deg": 90}, "view_angle_deg must be 360 under the policy 'capstone', got 90"),
    ({"dropout_rate": 1.01}, "dropout_rate must be at least 0 and at most 1, got 1.01"),
    ({"dropouts": "stay"}, "dropouts must be one of leave, fixed, got 'stay'"),
    ({"side_m": 1.0}, "side_m must be at least 2"),
    ({"hunter_poses": ((1.0, 1.0, 0.0),)}, "hunter_poses must be 4 poses"),
    ({"hunter_poses": ((1.0, 99.0, 0.0),) * 4}, "hunter_poses[0].y must be at least 0 and at most 11.0889, got 99.0"),
    ({"faults": {"kill_down": 1.5}}, "faults.kill_down must be at least 0 and at most 1, got 1.5"),
    ({"gains": {"kp": 1.0}}, "unknown setting gains.kp: did you mean kp_"),
    ({"spawn_frequenzy_hz": 1}, "unknown setting 'spawn_frequenzy_hz': did you mean spawn_frequency_hz"),
    ({"teams": ((0, 1), (2,))}, TEAMS),
    (
        {"teams": ((0, 1), (1, 2, 3))},
        TEAMS,
    ),
    (
        {"teams": ((0, 1, 2, 3), ())},
        TEAMS,
    ),
    (
        {"teams": ((0, 1.0), (2, 3))},
        TEAMS,
    ),
    ({"teams": 2}, "teams must be a tuple of tuples of seats, such as ((0, 1), (2, 3)), got 2"),
    ({"team_share": 1.1}, "team_share must be at least 0 and at most 1, got 1.1"),
    ({"spawning": 0}, "spawning must be true or false, got 0 (int)"),
    ({"prey": 33, "initial_targets": 40, "max_targets": 40}, "prey must be a whole number from 0 to 32, got 33"),
    ({"prey": 9}, "prey must be a whole number from 0 to 8 (initial_targets, which include prey), got 9"),
    ({"hunters_per_catch": 0}, "hunters_per_catch must be a whole number from 1 to 64, got 0"),
    ({"hunters_per_catch": 1.5}, "hunters_per_catch must be a whole number from 1 to 64, got 1.5 (float)"),
    ({"hunters_per_catch": 2}, "hunters_per_catch must be 1 unless teams are given, got 2"),
    (
        {"hunters_per_catch": 3, "teams": ((0, 1), (2, 3))},
        "hunters_per_catch must be a whole number from 1 to 2 (the size of the largest team), got 3",
    ),
    (
        {"hunters_per_catch": 2, "teams": ((0, 1), (2, 3)), "policy": "capstone"},
        "hunters_per_catch must be 1 under the policy 'capstone', got 2",
    ),
    ({"prey": 1, "target_budget": 20}, "target_budget must be None if the arena has prey, got 20"),
    ({"prey_returns_s": -0.1}, "prey_returns_s must be at least 0 and at most 1e+09, got -0.1"),
    ({"prey_rewards": {"caught": INFINITY}}, "prey_rewards.caught must be at least -1e+06 and at most 1e+06, got inf"),
    ({"prey_rewards": 3}, "prey_rewards must be PreyRewardWeights(...) or a mapping, got 3"),
    ({"render_mode": "rgb"}, "render_mode must be one of None, rgb_array, human, got 'rgb'"),
    ({"time_limit_s": np.array([5])}, "time_limit_s must be above 0 and at most 1e+09, got array([5]) (ndarray)"),
]


@pytest.mark.parametrize(("overrides", "message"), BAD_CONFIGS, ids=lambda value: str(value)[:40])
def test_a_config_that_cannot_be_is_refused(overrides, message):
    """The message names the setting, the requirement and the value."""
    with pytest.raises(ConfigError, match=re.escape(message)):
        catch_arena.parallel_env(**overrides)


@pytest.mark.parametrize("seed", [-1, 2**64, 1.5, "7", True])
def test_a_seed_that_is_none_is_refused(seed):
    """Whole numbers below 2^64 only; the episode under way goes on."""
    env = catch_arena.parallel_env()
    env.reset(seed=1)
    before = env.digest()
    with pytest.raises(ConfigError, match="seed must be a whole number from 0 to"):
        env.reset(seed=seed)

    assert env.digest() == before


def test_a_refused_reset_after_the_end_changes_nothing():
    """The infos still say who was cut off."""
    env = catch_arena.parallel_env("duel", max_cycles=1)
    env.reset(seed=1)
    env.step(good(env))
    saved = env.save()
    with pytest.raises(ConfigError):
        env.reset(seed=-1)
    assert env.save() == saved


def good(env):
    return {agent: env.action_space(agent).sample() for agent in env.agents}


@pytest.mark.parametrize(
    ("control", "action"), [("target", 9), ("velocity", (NAN, 0.0)), ("full", {"cmd_vel": (0.0, 0.0), "catch": 9})]
)
def test_a_bad_action_is_refused_and_nothing_moves(control, action):
    """The error names the hunter, which may act again; tests/contract/test_actions.py has every kind of action."""
    env, turns = catch_arena.parallel_env(control=control), catch_arena.env(control=control)
    for each in (env, turns):
        each.reset(seed=2)
    before = env.digest()
    with pytest.raises(ActionError, match="hunter_3: "):
        env.step({**good(env), "hunter_3": action})
    with pytest.raises(ActionError, match="hunter_0: "):
        turns.step(action)
    assert env.digest() == before == turns.digest()
    assert turns.agent_selection == "hunter_0"


def test_agents_that_are_missing_or_unknown_are_named():
    """Neither is guessed."""
    env = catch_arena.parallel_env()
    env.reset(seed=2)
    before = env.digest()
    with pytest.raises(ActionError, match="got none for hunter_2"):
        env.step({"hunter_0": 0, "hunter_1": 0, "hunter_3": 0})
    with pytest.raises(ActionError, match="unknown agent 'hunter_4': did you mean hunter_"):
        env.step({**good(env), "hunter_4": 0})
    with pytest.raises(ActionError, match="actions must map each agent"):
        env.step([0, 0, 0, 0])
    with pytest.raises(ActionError, match="unknown agent 'turtle1'"):
        env.observation_space("turtle1")

    assert env.digest() == before


def test_a_step_at_the_wrong_time_is_refused():
    """Before the first reset, and after the end."""
    env = catch_arena.parallel_env(max_cycles=1)
    for call in (lambda: env.step({}), env.world, env.state, env.digest, env.replay):
        with pytest.raises(EpisodeError, match="reset"):
            call()
    env.reset(seed=1)
    actions = good(env)
    env.step(actions)
    last = env.digest()
    for late in (actions, np.zeros(2), None):
        with pytest.raises(EpisodeError, match="the episode is over"):
            env.step(late)

    assert env.step({}) == ({}, {}, {}, {}, {})  # nobody is left to act
    assert env.digest() == last


def test_a_withdrawn_hunter_leaves_in_good_order():
    """R1.6 in the parallel env: one more step and termination."""
    env = catch_arena.parallel_env(max_cycles=10)
    env.reset(seed=3)
    env.withdraw("hunter_1")
    observations, _, terminations, _, _ = env.step(good(env))

    assert terminations == {"hunter_0": False, "hunter_1": True, "hunter_2": False, "hunter_3": False}
    assert "hunter_1" in observations
    assert env.agents == ["hunter_0", "hunter_2", "hunter_3"]

    observations, rewards, _, _, infos = env.step(good(env))

    assert set(observations) == set(rewards) == set(infos) == set(env.agents)


def test_steps_at_the_wrong_time_are_refused_under_aec_too():
    """Our own error before the first reset and after the end, from `step` and from `last`."""
    env = catch_arena.env("duel", max_cycles=1)
    for call in (lambda: env.step(0), env.last, env.world):
        with pytest.raises(EpisodeError, match="no episode has begun"):
            call()
    env.reset(seed=1)
    for _ in range(2):
        env.step(0)
    with pytest.raises(ActionError, match="hunter_0: an action must be None after the agent's end, got 1"):
        env.step(1)
    for _ in env.agent_iter():
        env.step(None)
    with pytest.raises(EpisodeError, match="the episode is over"):
        env.step(0)

    assert env.world().step == 1


def test_a_loop_over_the_turns_goes_on_after_an_illegal_action():
    """The same agent is asked again."""
    env = catch_arena.env("duel", max_cycles=1)
    env.reset(seed=1)
    asked = []
    for agent in env.agent_iter(3):
        asked.append(agent)
        if len(asked) == 1:
            with pytest.raises(ActionError):
                env.step(99)
        else:
            env.step(0)
    assert asked == ["hunter_0", "hunter_0", "hunter_1"]


@pytest.mark.parametrize(
    "arguments",
    [
        {"requests": None},
        {"hunters": None},
        {"caught": None},
        {"inactive": 1},
        {"policy": ["nearest"]},
        {"hunters": ["12"]},
        {"hunters": [(0.0, NAN)]},
        {"targets": [("t", (0, 0))]},
        {"requests": [(1, "t")]},
        {"requests": ["x"]},
        {"reach_m": 0},
        {"reach_m": [0.3, 0.3]},
        {"caught": ["t"]},
        {"caught": "a"},
        {"kill_refused": [1]},
        {"targets": {1: (1.0, 1.0)}},
        {"requests": [(True, "t")]},
        {"reach_m": NAN},
        {"seed": -1},
        {"seed": 2**64},
        {"step": None},
        {"match_over": "no"},
        {"kill_service_up": None},
    ],
    ids=repr,
)
def test_arbitrate_refuses_what_it_cannot_judge(arguments):
    """With an error of ours, whatever is given."""
    good = {"hunters": [(0.0, 0.0)], "targets": {"t": (0.0, 0.1)}, "requests": [(0, "t")]}
    with pytest.raises(CatchArenaError):
        catch_arena.arbitrate(**{**good, **arguments})


def test_limits_of_hunters_that_differ_need_a_seat():
    """R2.7: nobody is told the first one's, as if all had them."""
    config = catch_arena.scenario("unequal")
    with pytest.raises(
        ConfigError, match=r"the limits of these hunters differ: give a seat, Limits.of\(config, seat\)"
    ):
        catch_arena.Limits.of(config)
    assert [catch_arena.Limits.of(config, seat).reach_m for seat in range(4)] == [0.2, 0.3, 0.4, 0.5]


@pytest.mark.parametrize(
    "call",
    [
        catch_arena.Limits.of,
        catch_arena.PreyLimits.of,
        catch_arena.columns,
        prey_columns,
        state_columns,
        catch_arena.Engine,
    ],
)
@pytest.mark.parametrize("wrong", ["duel", 3, {"hunters": 2}], ids=repr)
def test_what_is_no_config_is_refused(call, wrong):
    message = "config must be an ArenaConfig, such as scenario(name) returns, got "
    with pytest.raises(ConfigError, match=f"^{re.escape(message)}"):
        call(wrong)


def test_a_seat_that_an_arena_lacks_has_no_limits():
    with pytest.raises(ConfigError, match=r"^seat must be from 0 to 1, got 2$"):
        catch_arena.Limits.of(catch_arena.scenario("duel"), 2)


def begun(make=catch_arena.parallel_env):
    env = make("duel")
    env.reset(seed=1)
    return env


def recorded():
    env = catch_arena.parallel_env("duel", max_cycles=1)
    env.record()
    env.reset(seed=1)
    env.step(good(env))
    return env.replay()


def service():
    return begun(catch_arena.ArenaService)


LIMITS = catch_arena.Limits.of(catch_arena.scenario("duel"))
PREY_LIMITS = catch_arena.PreyLimits.of(catch_arena.scenario("tag"))
CALLS = [
    ("unknown agent", lambda wrong: begun().check_action(wrong, 0)),
    ("unknown agent", lambda wrong: begun().withdraw(wrong)),
    ("unknown agent", lambda wrong: begun(catch_arena.env).observe(wrong)),
    ("unknown agent", lambda wrong: begun(catch_arena.env).action_space(wrong)),
    ("spawn: x must lie in", lambda wrong: service().spawn(wrong, 1.0)),
    ("spawn: y must lie in", lambda wrong: service().spawn(1.0, wrong)),
    ("spawn: theta must lie in", lambda wrong: service().spawn(1.0, 1.0, wrong)),
    ("cmd_vel must map", lambda wrong: service().step(wrong)),
    ("active_targets must map", lambda wrong: service().step(active_targets=wrong)),
    ("names must have 2 entries", lambda wrong: catch_arena.ArenaService("duel").record(wrong)),
    ("unknown scenario", catch_arena.parallel_env),
    ("unknown scenario", catch_arena.env),
    ("file must be a path", lambda wrong: recorded().save(wrong)),
    ("replay must be a Replay", catch_arena.explain),
    ("replay must be a Replay", lambda wrong: catch_arena.explain_step(wrong, 1)),
    ("step must be a whole number", lambda wrong: catch_arena.explain_step(recorded(), wrong)),
    ("at must be a number of seconds", lambda wrong: step_at(recorded(), wrong)),
    ("replay must be a Replay", lambda wrong: catch_arena.what_if(wrong, wrong)),
    ("contest must be a Contest", lambda wrong: catch_arena.what_if(recorded(), wrong)),
    ("limits must be a Limits", lambda wrong: catch_arena.View([0.0] * 57, (), wrong)),
    ("limits must be a PreyLimits", lambda wrong: catch_arena.PreyView([0.0] * 27, wrong)),
    ("observations must be", lambda wrong: catch_arena.BatchView(wrong, np.ones((1, 9)), LIMITS)),
    ("limits must be a Limits", lambda wrong: catch_arena.BatchView(np.zeros((1, 57)), np.ones((1, 9)), wrong)),
    ("observations must be", lambda wrong: catch_arena.PreyBatchView(wrong, PREY_LIMITS)),
    ("limits must be a PreyLimits", lambda wrong: catch_arena.PreyBatchView(np.zeros((1, 27)), wrong)),
    ("settings must map names to values", catch_arena.ArenaConfig.from_dict),
    ("unknown scenario", catch_arena.scenario),
]
"""Beginning of the error, and a call with one wrong argument."""


@pytest.mark.parametrize(("message", "call"), CALLS)
@pytest.mark.parametrize("wrong", [[], True, b"x"], ids=repr)
def test_a_wrong_argument_is_named_in_an_error_of_ours(message, call, wrong):
    with pytest.raises(CatchArenaError, match=f"^{message}.*{re.escape(repr(wrong))}"):
        call(wrong)


class Silent:
    def __repr__(self):
        raise ValueError("no")


@pytest.mark.parametrize(
    "call",
    [
        lambda wrong: begun().reset(seed=wrong),
        lambda wrong: begun().step(wrong),
        lambda wrong: begun().step({"hunter_0": 0, "hunter_1": 0, wrong: 0}),
        lambda wrong: begun().step({"hunter_0": wrong, "hunter_1": 0}),
        lambda wrong: begun().withdraw(wrong),
        lambda wrong: begun(catch_arena.env).step(wrong),
        lambda wrong: begun(catch_arena.VectorArena).reset(seed=wrong),
        lambda wrong: begun(catch_arena.VectorArena).world(wrong),
        lambda wrong: catch_arena.VectorArena("duel", wrong),
    ],
)
@pytest.mark.parametrize("wrong", [10**5000, "x" * 100_000, Silent()], ids=["number", "text", "no repr"])
def test_a_value_that_cannot_be_shown_is_refused_in_a_short_line(call, wrong):
    """Python refuses to print the longest numbers."""
    with pytest.raises(CatchArenaError) as error:
        call(wrong)
    assert len(str(error.value)) < 300


@pytest.mark.parametrize("make", [catch_arena.parallel_env, catch_arena.env])
def test_options_of_a_reset_are_a_dict_or_none(make):
    """Before the first reset too, after which nothing has begun."""
    env = make("duel")
    for options in (3, [], "x"):
        with pytest.raises(ConfigError, match=rf"^options must be a dict or None, got {re.escape(repr(options))} \("):
            env.reset(options=options)
    with pytest.raises(EpisodeError, match="no episode has begun"):
        env.step(0)
    env.reset(seed=1, options={"unused": 1})
    before = env.digest()
    with pytest.raises(ConfigError, match="options must be a dict or None, got 3"):
        env.reset(seed=2, options=3)
    assert env.digest() == before


def test_a_name_that_no_target_has_kills_none():
    service = begun(catch_arena.ArenaService)
    assert [service.kill(name) for name in ([], None, 3)] == [False, False, False]


@pytest.mark.parametrize("observation", [None, 3, [], [0.0], [0.0] * 100, object(), {"observation": 1}])
def test_what_is_no_observation_makes_no_view(observation):
    config = catch_arena.scenario("tag")
    for make in (
        lambda: catch_arena.View(observation, [1], catch_arena.Limits.of(config, 0)),
        lambda: catch_arena.PreyView(observation, catch_arena.PreyLimits.of(config)),
    ):
        with pytest.raises(ConfigError, match=r"^observation must be a vector of \d+ numbers, as env.step returns it "):
            make()
