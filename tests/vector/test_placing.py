"""`VectorArena.place` begins episodes with given bodies, which play on as they would have."""

import numpy as np
import pytest

from catch_arena import VectorArena
from catch_arena.errors import ConfigError, EpisodeError
from catch_arena.verdicts import Verdict

NOWHERE = np.nan


def bodies(arena, row):
    """Bodies of an arena, as `place` takes them."""
    world = arena.world(row)
    hunters = [
        (one.x, one.y, one.theta, one.linear_velocity) if not one.withdrawn else (NOWHERE,) * 4 for one in world.hunters
    ]
    targets = [
        (one.x, one.y, one.theta, one.linear_velocity, (world.time_ms - one.spawned_ms) / 1000.0)
        for one in world.targets
    ]
    return hunters, targets + [(NOWHERE,) * 5] * (arena.config.max_targets - len(targets))


@pytest.mark.parametrize("scenario", ["standard", "unequal", "fog", "duel"])
def test_an_arena_with_the_bodies_of_another_sees_and_plays_the_same_from_there(scenario):
    settings = {"control": "velocity", "spawning": False, "initial_targets": 8}
    played = VectorArena(scenario, 3, copy=True, **settings)
    played.reset(seed=5)
    rng = np.random.default_rng(1)
    shape = (3, played.num_hunters, 2)
    for _ in range(60):
        before, *_ = played.step(commands=rng.uniform(-0.2, 1.0, shape))
    hunters, targets = zip(*(bodies(played, row) for row in range(3)), strict=True)
    placed = VectorArena(scenario, 3, copy=True, **settings)
    placed.reset(seed=99)
    seen, _ = placed.place(hunters, targets, steps=60)
    own = [column.name for column in columns_of(played)]
    compared = [index for index, name in enumerate(own) if "score" not in name and name != "angular_velocity"]
    np.testing.assert_array_equal(seen[..., compared], before[..., compared])
    for _ in range(60):
        actions = rng.uniform(-0.2, 1.0, shape)
        before, *_ = played.step(commands=actions)
        seen, *_ = placed.step(commands=actions)
        np.testing.assert_array_equal(seen[..., compared], before[..., compared])


def columns_of(arena):
    from catch_arena.layout import columns

    return columns(arena.config)


def test_targets_are_numbered_by_age_and_those_that_follow_come_from_the_own_seed():
    arena = VectorArena("standard", 2, control="velocity")
    arena.reset(seed=3)
    hunters = np.tile([[1.0, 1.0, 0.0, 0.0]], (2, 4, 1))
    targets = np.full((2, 3, 5), NOWHERE)
    targets[0] = [(5.0, 5.0, 0.0, 0.0, 1.0), (6.0, 6.0, 0.0, 0.0, 2.5), (7.0, 7.0, 0.0, 0.0, 0.0)]
    arena.place(hunters, targets, steps=[30, 0])
    world = arena.world(0)
    assert [(one.number, one.x, one.spawned_ms) for one in world.targets] == [
        (1, 6.0, 500),
        (2, 5.0, 2000),
        (3, 7.0, 3000),
    ]
    assert (world.time_ms, world.step, arena.world(1).targets) == (3000, 30, ())
    later = []
    for seed in (3, 3, 4):
        arena.reset(seed=seed)
        arena.place(hunters, targets, steps=[30, 0])
        for _ in range(20):
            arena.step(commands=np.zeros((2, 4, 2), np.float32))
        later.append([(one.x, one.y, one.spawned_ms) for one in arena.world(0).targets[3:]])
    assert later[0] == later[1] != later[2]
    assert later[0]


def test_what_was_counted_before_counts_no_more():
    """The episode's figures are those of what followed `place`: there is no rank 5, and so a request is MALFORMED."""
    arena = VectorArena("standard", 2, control="full", time_limit_s=1.0, spawning=False, initial_targets=1)
    arena.reset(seed=3)
    hunters, targets = np.tile([[1.0, 1.0, 0.0, 0.0]], (1, 4, 1)), [[(9.0, 9.0, 0.0, 0.0, 0.0)]]
    actions = np.full((2, 4), 5), np.zeros((2, 4, 2), np.float32)
    for _ in range(4):
        arena.step(*actions)
    arena.place(hunters, targets, steps=4, arenas=[1])
    for _ in range(6):
        *_, infos = arena.step(*actions)
    malformed = infos["episode"]["verdicts"][:, :, Verdict.MALFORMED - 1]
    assert malformed.tolist() == [[10.0] * 4, [6.0] * 4]


def test_who_is_placed_nowhere_takes_no_part_and_other_rows_play_on():
    arena = VectorArena("standard", 3, control="velocity", copy=True)
    arena.reset(seed=3)
    digests = [arena.digest(row) for row in range(3)]
    hunters = np.tile([[4.0, 4.0, 0.0, 1.0]], (1, 4, 1))
    hunters[0, 2] = NOWHERE
    seen, _ = arena.place(hunters, np.zeros((1, 0, 5)), arenas=[1])
    assert [arena.digest(row) == digest for row, digest in enumerate(digests)] == [True, False, True]
    assert [one.withdrawn for one in arena.world(1).hunters] == [False, False, True, False]
    present = [index for index, column in enumerate(columns_of(arena)) if column.name.endswith("present")]
    assert seen[1, 0, present].sum() == 2  # two rivals, no target


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"hunters": np.zeros((1, 3, 4))}, "hunters must be numbers of the shape \\(1, 4, 4\\)"),
        ({"targets": np.zeros((1, 99, 5))}, "targets must be numbers of the shape \\(1, 0 to 16, 5\\)"),
        ({"targets": "somewhere"}, "targets must be numbers"),
        ({"hunters": [[(99.0, 1.0, 0.0, 0.0)] * 4]}, "hunters must have x from 0 to 11.* got 99 at "),
        ({"hunters": [[(1.0, 1.0, 1e18, 0.0)] * 4]}, "hunters must have a heading from -1000 to 1000"),
        ({"hunters": [[(1.0, 1.0, 0.0, 2.5)] * 4]}, "hunters must have a velocity from 0 to 2, got 2.5"),
        ({"targets": [[(1.0, 1.0, 0.0, 1.0, 0.0)]]}, "targets must have a velocity from 0 to 0, got 1"),
        ({"targets": [[(1.0, 1.0, 0.0, 0.0, 4.0)]]}, "targets must have an age from 0 to .*, got 4"),
        ({"steps": -1}, "steps must be one or 1 numbers from 0 to 599"),
        ({"steps": 600}, "steps must be one or 1 numbers from 0 to 599"),
    ],
)
def test_what_cannot_be_placed_is_refused_in_one_line_and_nothing_has_moved(changes, error):
    arena = VectorArena("standard", 1)
    arena.reset(seed=1)
    digest = arena.digest(0)
    given = {"hunters": [[(1.0, 1.0, 0.0, 0.0)] * 4], "targets": np.zeros((1, 0, 5)), "steps": 0, **changes}
    with pytest.raises(ConfigError, match=error):
        arena.place(**given)
    assert arena.digest(0) == digest


def test_an_arena_that_has_not_begun_or_has_prey_takes_no_bodies():
    with pytest.raises(EpisodeError):
        VectorArena("standard").place(np.zeros((1, 4, 4)), np.zeros((1, 0, 5)))
    herd = VectorArena("herd")
    herd.reset(seed=1)
    with pytest.raises(ConfigError, match="does not support arenas with prey"):
        herd.place(np.zeros((1, 4, 4)), np.zeros((1, 0, 5)))
