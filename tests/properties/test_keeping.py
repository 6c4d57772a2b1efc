"""R10.2: what is saved, copied or pickled goes on bit for bit, at any point of a run."""

import copy
import dataclasses
import pickle
from random import Random

import numpy as np
import pytest
from properties.matches import some_config, some_seed

import catch_arena
from catch_arena.config import ArenaConfig
from catch_arena.errors import ConfigError, EpisodeError

MATCHES = 12


def some_action(source, env, agent):
    """Any legal one."""
    rank = source.randrange(env.config.targets_seen + 1)
    command = [source.uniform(-1, 1), source.uniform(-1, 1)]
    controls = (*env.config.controls, *["velocity"] * env.config.prey)
    control = controls[env.possible_agents.index(agent)]
    return {"target": rank, "velocity": command, "full": {"cmd_vel": command, "catch": rank}}[control]


def seen(results):
    """Everything that a reset or a step gave, as text with every bit."""
    with np.printoptions(threshold=10**9, floatmode="unique"):
        return repr([dict(result) for result in results])


def played(env, source, steps, seed_after):
    """So many steps, through the ends of episodes, and all that they gave."""
    found = []
    for _ in range(steps):
        if not env.agents:
            found.append(seen(env.reset(seed=seed_after)))
        found.append(seen(env.step({agent: some_action(source, env, agent) for agent in env.agents})))
        found.append((env.digest(), tuple(env.agents), int(env.np_random.integers(1 << 40))))
    return found


@pytest.mark.rule("R10.2")
@pytest.mark.parametrize("match", range(MATCHES))
def test_r10_2_an_env_goes_on_from_any_point(match):
    """Restored, restored in another env, cloned, deep-copied and pickled: everything that steps give, infos included.

    Hunters are withdrawn and drop out on the way, and some runs are recorded.
    """
    source = Random(match)
    config = some_config(source).replace(max_cycles=source.randrange(3, 30))
    env = catch_arena.parallel_env(config)
    recorded = match % 3 == 0
    if recorded:
        env.record()
    env.reset(seed=some_seed(source))
    played(env, source, source.randrange(20), 5)
    if len(env.agents) > 1 and source.random() < 0.5:
        env.withdraw(source.choice(env.agents))
        played(env, source, source.randrange(3), 6)
    saved, twins = env.save(), [env.clone(), copy.deepcopy(env), pickle.loads(pickle.dumps(env))]  # noqa: S301
    steps, choices = source.randrange(1, 25), source.getstate()
    expected = played(env, source, steps, 7)
    replay = env.replay().digests if recorded else None
    other = catch_arena.parallel_env(config)
    other.restore(pickle.loads(pickle.dumps(saved)))  # noqa: S301
    for _ in range(2):
        observations, _ = env.restore(saved)
        assert list(observations) == env.agents
        for again in (env, other, *twins):
            source.setstate(choices)
            assert played(again, source, steps, 7) == expected
            if replay is not None and again is not other:
                assert again.replay().digests == replay
        other.restore(saved)
        twins = []


@pytest.mark.rule("R10.2")
def test_r10_2_what_follows_a_cut_episode_is_told_as_it_was():
    """A reset without a seed tells of the end of the episode before, and so does what goes on from there."""
    env = catch_arena.parallel_env("duel", max_cycles=2)
    env.reset(seed=1)
    for _ in range(2):
        env.step(dict.fromkeys(env.agents, 0))
    first = env.reset()
    assert all(info["TimeLimit.truncated"] for info in first[1].values())
    assert seen(env.restore(env.save())) == seen(first)
    env.step(dict.fromkeys(env.agents, 0))
    assert not any(info["TimeLimit.truncated"] for info in env.restore(env.save())[1].values())


def batch_actions(source, arena):
    """Legal ones for all."""
    ranks = source.integers(0, arena.config.targets_seen + 1, (arena.num_envs, arena.num_hunters))
    shape = (arena.num_envs, arena.num_hunters + arena.num_prey, 2)
    return ranks, source.uniform(-1, 1, shape).astype(np.float32)


def turned(actions):
    """Every row's for the next row."""
    return tuple(np.roll(those, 1, axis=0) for those in actions)


def flat(results):
    """All arrays of a step or a reset, as bytes."""
    if isinstance(results, np.ndarray):
        return results.tobytes()
    values = results.values() if isinstance(results, dict) else results
    return tuple(flat(value) for value in values)


@pytest.mark.rule("R10.2")
@pytest.mark.parametrize("auto_reset", [True, False])
@pytest.mark.parametrize(
    ("match", "size"),
    [(0, 3), (2, 3), (4, 1), (5, 1), *(pytest.param(match, 40, marks=pytest.mark.large) for match in (1, 3))],
)
def test_r10_2_a_batch_goes_on_from_any_point(match, size, auto_reset):
    """The figures and the last observations of past episodes too; and so does each row, in another row."""
    source = Random(100 + match)
    config = some_config(source).replace(max_cycles=source.randrange(3, 20))
    arena = catch_arena.VectorArena(config, size, auto_reset=auto_reset)
    arena.reset(seed=some_seed(source))
    draw = np.random.default_rng(match)
    for _ in range(source.randrange(25)):
        arena.step(*batch_actions(draw, arena))
    saved, row = arena.save(), arena.save(size - 1)
    twins = [arena.clone(), copy.deepcopy(arena), pickle.loads(pickle.dumps(arena))]  # noqa: S301
    script = [batch_actions(draw, arena) for _ in range(25)]
    expected = [flat(arena.step(*actions)) for actions in script]
    last = arena.digest(size - 1)
    other = catch_arena.VectorArena(config, size, auto_reset=auto_reset)
    other.restore(saved)
    arena.restore(saved)
    for again in (arena, other, *twins):
        assert [flat(again.step(*actions)) for actions in script] == expected
    other.restore(row, 0)
    for actions in script:
        other.step(*turned(actions))
    assert other.digest(0) == last


def test_a_state_goes_between_arenas_that_reset_by_themselves_and_that_do_not():
    """The first keep unchanged what the second do not save."""
    config = ArenaConfig(hunters=2, max_cycles=5)
    arenas = [catch_arena.VectorArena(config, 3, auto_reset=auto_reset) for auto_reset in (True, False)]
    for arena in arenas:
        arena.reset(seed=1)
        arena.step(np.ones((3, 2), dtype=int))
    for one, other in (arenas, arenas[::-1]):
        other.step(np.zeros((3, 2), dtype=int))
        other.restore(one.save())
        assert [other.digest(row) for row in range(3)] == [one.digest(row) for row in range(3)]
        other.restore(one.save(0), 2)
        assert other.digest(2) == one.digest(0)
        one.restore(other.save())


def played_turns(env, source, turns):
    """So many turns, through the ends of episodes, and all that the hunters and the prey saw."""
    found = []
    for _ in range(turns):
        if not env.agents:
            env.reset(seed=7)
        agent = env.agent_selection
        *observed, terminated, truncated, info = env.last()
        found.append((agent, terminated, truncated, seen([{"observed": observed}, {"info": info}]), env.digest()))
        env.step(None if terminated or truncated else some_action(source, env.unwrapped, agent))
        found.append((dict(env.rewards), dict(env.terminations), dict(env.truncations), list(env.agents)))
    return found


@pytest.mark.rule("R10.2")
@pytest.mark.parametrize("match", range(MATCHES))
def test_r10_2_an_aec_env_goes_on_from_any_turn(match):
    """Between two turns of a step too, with the actions that have been given and not yet played, and among the last
    turns of agents that have been terminated.
    """
    source = Random(match)
    config = some_config(source).replace(max_cycles=source.randrange(2, 9))
    env, other = catch_arena.env(config), catch_arena.env(config)
    env.reset(seed=some_seed(source))
    for _ in range(8):
        played_turns(env, source, source.randrange(1, 9))
        saved, twins = env.save(), [env.clone(), copy.deepcopy(env), pickle.loads(pickle.dumps(env))]  # noqa: S301
        turns, choices = source.randrange(1, 40), source.getstate()
        expected = played_turns(env, source, turns)
        for restored in (env, other, env):
            restored.restore(pickle.loads(pickle.dumps(saved)))  # noqa: S301
        for again in (env, other, *twins):
            source.setstate(choices)
            assert played_turns(again, source, turns) == expected


def test_what_callers_write_into_does_not_change_what_is_saved():
    """Actions that have not been played yet, and what agents were told, also on their last turn."""
    env = catch_arena.env("duel", control="velocity", max_cycles=2)
    env.reset(seed=3)
    for turn in range(5):
        action = np.array([1.0, 0.5])
        over = env.terminations[env.agent_selection] or env.truncations[env.agent_selection]
        env.step(None if over else action)
        saved, expected = env.save(), seen([{"last": env.last()}])
        for _ in range(2):
            action[:] = 0.0
            observation, *_, info = env.last()
            observation[:] = 9.0
            info["reward_parts"][:] = 9.0
            env.restore(saved)
            assert seen([{"last": env.last()}]) == expected
        if turn == 0:
            assert env.unwrapped._actions["hunter_0"].tolist() == [1.0, 0.5]


def test_what_an_aec_env_cannot_go_on_from_is_refused():
    """Nor can the parallel env go on from a turn; nothing changes."""
    env, other = catch_arena.env("duel"), catch_arena.env("standard")
    with pytest.raises(EpisodeError, match=r"cannot call save\(\): no episode has begun; call reset\(\) first"):
        env.save()
    for one in (env, other):
        one.reset(seed=1)
        one.step(1)
    before = env.digest()
    mixed = (env, "an AEC", env.unwrapped.save()), (env.unwrapped, "a parallel", env.save())
    for one, kind, wrong in ((env, "an AEC", 3), *mixed):
        shown = str(wrong)[: len("SavedEpisode")]
        with pytest.raises(
            ConfigError, match=rf"saved must be a state that {kind} env's save\(\) returned, got {shown}"
        ):
            one.restore(wrong)
    with pytest.raises(ConfigError, match="saved must come from an arena with an equal config"):
        env.restore(other.save())
    assert (env.digest(), env.agent_selection) == (before, "hunter_1")


def test_what_another_version_has_kept_is_refused_before_anything_changes():
    """A state of another length, with other rows, without what was added since, or of other agents."""
    env, batch = catch_arena.parallel_env("duel"), catch_arena.VectorArena("duel", 2)
    env.reset(seed=1)
    batch.reset(seed=1)
    before = env.digest(), batch.digest(0), batch.digest(1)
    episode, both, row = env.save(), batch.save(), batch.save(0)
    shorter = [dataclasses.replace(saved, memory=saved.memory[:-8]) for saved in (episode.arena, both, row)]
    moved = [dataclasses.replace(saved, layout="0") for saved in (episode.arena, both, row)]
    for (arena, others, one), error in (
        (shorter, r"an arena of the same kind, with \d+ bytes, got"),
        (moved, "this version"),
    ):
        for call in (
            lambda arena=arena: env.restore(dataclasses.replace(episode, arena=arena)),
            lambda others=others: batch.restore(others),
            lambda one=one: batch.restore(one, 1),
        ):
            with pytest.raises(ConfigError, match=f"saved must come from {error}"):
                call()
    old = object.__new__(type(episode))  # as unpickled from a version with fewer fields
    for one, kind in ((env, "a parallel"), (catch_arena.env("duel"), "an AEC")):
        with pytest.raises(ConfigError, match=f"saved must be a state that {kind} env's save"):
            one.restore(old)
    renamed = catch_arena.parallel_env("duel", agent_names=["hunter_1", "hunter_0"])
    with pytest.raises(ConfigError, match="saved must come from an env with the agents"):
        renamed.restore(episode)
    assert (env.digest(), batch.digest(0), batch.digest(1)) == before


@pytest.mark.parametrize("match", range(MATCHES))
def test_what_is_saved_twice_is_equal_until_something_happens(match):
    """In every kind of environment; what a replay keeps of it too."""
    source = Random(match)
    lasting = {"spawning": True, "target_budget": None, "prey_returns_s": 2.0, "dropout_rate": 0.0}
    config = some_config(source).replace(max_cycles=30, **lasting)
    env, twin = catch_arena.parallel_env(config), catch_arena.parallel_env(config)
    for each in (env, twin):
        each.record()
        each.reset(seed=match)
    saved = [env.save()]
    for _ in range(3):
        actions = {agent: some_action(source, env, agent) for agent in env.agents}
        for each in (env, twin):
            each.step(actions)
        saved.append(env.save())
    turns = catch_arena.env(config)
    turns.reset(seed=match)
    turns.step(some_action(source, turns.unwrapped, turns.agent_selection))
    given = turns.save()
    turns.step(some_action(source, turns.unwrapped, turns.agent_selection))
    batch = catch_arena.VectorArena(config, 2)
    batch.reset(seed=match)

    assert saved[3] == env.save() == twin.save() == copy.deepcopy(saved[3])
    assert [saved[3] == other for other in (*saved[:3], None)] == [False] * 4
    assert given == copy.deepcopy(given)
    assert (turns.save() == turns.save(), turns.save() == given) == (True, False)
    assert batch.save() == batch.save()
    assert batch.save(0) == batch.save(0)
    assert batch.save(0) != batch.save(1)
    assert (batch.save() != batch.save()) is False


def test_replays_are_equal_if_they_hold_the_same_match(tmp_path):
    """The one that was recorded, and each that is read from its file."""
    file = tmp_path / "m.replay"
    env = catch_arena.parallel_env("duel", control=("full", "velocity"))
    env.record()
    env.reset(seed=1)
    source = Random(1)
    for _ in range(4):
        env.step({agent: some_action(source, env, agent) for agent in env.agents})
    env.replay().save(file)
    load = catch_arena.Replay.load
    other = load(file)
    other.commands[2] = other.commands[2] * np.float32(0.5)

    assert load(file) == load(file) == env.replay()
    assert load(file) != other
    assert load(file) != "m.replay"
