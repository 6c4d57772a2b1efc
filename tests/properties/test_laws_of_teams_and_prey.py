"""The laws that follow from the rulebook's chapters 11 and 12, on matches that hypothesis looks for."""

from random import Random

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from properties.matches import settings_of, some_batch_actions, some_config, some_teams
from properties.test_laws import MATCHES, SEEDS, SOURCES, STEPS

from catch_arena.config import ArenaConfig
from catch_arena.core import rows
from catch_arena.engine import Engine


def with_prey(source: Random) -> ArenaConfig:
    """Settings with prey in them."""
    config = some_config(source)
    if config.prey:
        return config
    initial = max(1, config.initial_targets)
    returns = source.choice([None, 0.0, 0.1, 0.34567])
    return config.replace(
        initial_targets=initial, prey=source.randint(1, initial), prey_returns_s=returns, target_budget=None
    )


def begin(config: ArenaConfig, seed: int) -> Engine:
    engine = Engine(config)
    engine.reset([seed])
    return engine


def is_over(engine: Engine) -> bool:
    return bool(engine.ends[0])


# ---- teams ----


@MATCHES
@given(source=SOURCES, seed=SEEDS, actions=SEEDS, data=st.data())
def test_the_order_of_teams_and_of_their_seats_does_not_matter(
    source: Random, seed: int, actions: int, data: st.DataObject
) -> None:
    """R11.1: the state, what is seen, what is paid: every bit; only a team's place in the list of scores is another."""
    config = some_config(source)
    teams = some_teams(source, config.hunters)
    order = data.draw(st.permutations(range(len(teams))))
    needed = 1 if config.policy == "capstone" else min(2, *map(len, teams))
    permuted = tuple(tuple(data.draw(st.permutations(teams[place]))) for place in order)
    one = begin(config.replace(teams=teams, hunters_per_catch=needed), seed)
    other = begin(config.replace(teams=permuted, hunters_per_catch=needed), seed)
    chosen = Random(actions)
    for _ in range(STEPS):
        assert bytes(one.digest(0)) == bytes(other.digest(0)), settings_of(config)
        for name in ("observations", "rewards", "parts", "prey_parts"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
        assert other.team_scores[0].tolist() == one.team_scores[0, order].tolist()
        given_ = some_batch_actions(chosen, config, 1)
        one.step(*given_)
        other.step(*given_)


@MATCHES
@given(source=SOURCES, seed=SEEDS, actions=SEEDS)
def test_teams_change_what_is_paid_and_nothing_that_is_ruled(source: Random, seed: int, actions: int) -> None:
    """R11.3, R11.2: with and without teams the states and rulings are the same; catches of mates and of rivals add up
    to those of all others; and a team that shares gets in sum what its hunters earned.
    """
    config = some_config(source).replace(dropout_rate=0.0, hunters_per_catch=1)
    teams = some_teams(source, config.hunters)
    alone, own = begin(config.replace(teams=None), seed), begin(config.replace(teams=teams, team_share=0.0), seed)
    shared = begin(config.replace(teams=teams, team_share=source.choice([0.25, 1.0])), seed)
    chosen = Random(actions)
    for _ in range(STEPS):
        given_ = some_batch_actions(chosen, config, 1)
        for engine in (alone, own, shared):
            engine.step(*given_)
        assert bytes(alone.digest(0)) == bytes(own.digest(0)) == bytes(shared.digest(0)), settings_of(config)
        assert alone.world(0).rulings == own.world(0).rulings == shared.world(0).rulings
        assert np.array_equal(own.parts, shared.parts)
        assert np.array_equal(own.parts[0, :, 1] + own.parts[0, :, 6], alone.parts[0, :, 1])
        assert not alone.parts[0, :, 6].any()
        assert np.array_equal(own.team_scores, shared.team_scores)
        for team, score in zip(teams, own.team_scores[0], strict=True):
            assert score == sum(own.world(0).hunters[seat].score for seat in team)
            assert np.isclose(own.rewards[0, team].sum(), shared.rewards[0, team].sum())


# ---- prey ----


@MATCHES
@given(source=SOURCES, seed=SEEDS, actions=SEEDS)
def test_prey_is_neither_lost_nor_doubled(source: Random, seed: int, actions: int) -> None:
    """R12.1, R12.3, R5.8: each prey plays an alive target that nobody else plays, or is out; its score counts the
    catches of the targets that it played; and every target that appeared came at reset, with a firing, or with a
    return.
    """
    config = with_prey(source)
    engine = begin(config, seed)
    chosen = Random(actions)
    counted = [0] * config.prey
    returns = 0
    for _ in range(STEPS):
        before = engine.world(0)
        engine.step(*some_batch_actions(chosen, config, 1))
        world = engine.world(0)
        played = {target.prey: target.name for target in world.targets if target.prey is not None}
        assert played == {prey.name: prey.target for prey in world.prey if prey.target is not None}
        alive = {target.name for target in world.targets}
        for index, (was, prey) in enumerate(zip(before.prey, world.prey, strict=True)):
            is_caught = prey.caught_by is not None
            assert is_caught == (was.target is not None and was.target not in alive)
            if is_caught:
                assert world.rulings[[one.hunter for one in world.rulings].index(prey.caught_by)].target == was.target
            counted[index] += is_caught
            assert prey.times_caught == counted[index]
            returns += prey.target is not None and prey.target != was.target
            assert (prey.caught_ms is None) == (prey.target is not None)
            if config.prey_returns_s is None:
                assert prey.times_caught == (prey.target is None)
        _, _, spawned, used, firings, full, down, refused = engine.state(0)[:8].tolist()
        assert returns == sum(counted) - sum(prey.target is None for prey in world.prey)
        assert spawned == config.initial_targets + firings - full - down - refused + returns
        assert used == spawned + refused
        assert len(world.targets) <= config.max_targets
        assert not (engine.ends[0] == rows.TERMINATED and config.prey_returns_s is not None)
        if is_over(engine):
            break


@MATCHES
@given(source=SOURCES, seed=SEEDS, actions=st.tuples(SEEDS, SEEDS))
def test_what_prey_does_changes_no_ruling_of_its_step(source: Random, seed: int, actions: tuple[int, int]) -> None:
    """R1.4, R5.1: the arbiter judges on S_t; and what prey that is out does changes nothing at all (R12.3)."""
    config = with_prey(source)
    one, other = begin(config, seed), Engine(config)
    chosen, otherwise = Random(actions[0]), Random(actions[1])
    for _ in range(STEPS):
        other.restore(one.save())
        choices, commands = some_batch_actions(chosen, config, 1)
        changed = commands.copy()
        changed[:, config.hunters :] = some_batch_actions(otherwise, config, 1)[1][:, config.hunters :]
        active = one.active[0, config.hunters :].copy()
        one.step(choices, commands)
        other.step(choices, changed)
        assert other.world(0).rulings == one.world(0).rulings, settings_of(config)
        assert [prey.caught_by for prey in other.world(0).prey] == [prey.caught_by for prey in one.world(0).prey]
        if not active.any():
            assert bytes(other.digest(0)) == bytes(one.digest(0))
        if is_over(one):
            break


@MATCHES
@given(source=SOURCES, seed=SEEDS, actions=st.tuples(SEEDS, SEEDS))
def test_withdrawn_prey_stands_still_and_is_paid_nothing(source: Random, seed: int, actions: tuple[int, int]) -> None:
    """R12.5: whatever it commands, each target that it plays stays where it was or appeared; its times caught go on to
    be counted, and it returns.
    """
    config = with_prey(source)
    one, other = begin(config, seed), begin(config, seed)
    index = source.randrange(config.prey)
    chosen, otherwise = Random(actions[0]), Random(actions[1])
    for _ in range(source.randint(0, 3)):
        given_ = some_batch_actions(chosen, config, 1)
        one.step(*given_)
        other.step(*given_)
    agent = config.hunters + index
    one.withdraw(0, agent)
    other.withdraw(0, agent)
    places: dict[str, tuple[float, float]] = {}
    for _ in range(STEPS):
        choices, commands = some_batch_actions(chosen, config, 1)
        changed = commands.copy()
        changed[0, agent] = some_batch_actions(otherwise, config, 1)[1][0, agent]
        for target in one.world(0).targets:
            if target.prey == config.prey_names[index]:
                assert places.setdefault(target.name, (target.x, target.y)) == (target.x, target.y)
        if is_over(one):
            break
        one.step(choices, commands)
        other.step(choices, changed)
        assert bytes(other.digest(0)) == bytes(one.digest(0)), settings_of(config)
        assert one.rewards[0, agent] == 0
        assert not one.prey_parts[0, index].any()
        assert one.world(0).prey[index].withdrawn
