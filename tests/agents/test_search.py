"""The agent that looks ahead acts legally, does bounded work, and sees only its view."""

from itertools import pairwise

import numpy as np
import pytest

from catch_arena import SCENARIOS, Limits, VectorArena, View, scenario
from catch_arena.agents.nearest import Agent as Nearest
from catch_arena.agents.search import (
    Agent,
    RolloutArena,
    Scene,
    Weights,
    circle_is_enough,
    look_ahead,
    on_the_lanes,
)
from catch_arena.batch_policy import BatchView
from catch_arena.layout import observation_size
from catch_arena.tournament.match_loop import play_match


def made():
    agent = Agent()
    agent.reset(1)
    return agent


def views_of(name, steps=12, rows=3):
    """Yield the views of all hunters of some arenas after each step, while they look ahead."""
    config = scenario(name, control="velocity")
    arena = VectorArena(config, rows, copy=True)
    seen, _ = arena.reset(seed=4)
    limits = [Limits.of(config, seat) for seat in range(config.hunters)]
    agent, columns = made(), observation_size(config)
    rest = np.zeros((rows, config.hunters + config.prey, 2), np.float32)
    for _ in range(steps):
        seen = seen[:, : config.hunters, :columns]
        views = [BatchView(seen[:, seat], np.zeros((rows, 0), np.int8), limits[seat]) for seat in range(config.hunters)]
        yield views
        commands = rest.copy()
        for seat, view in enumerate(views):
            commands[:, seat] = agent.act_batch(view)
        seen, *_ = arena.step(commands=commands)


@pytest.mark.parametrize("name", SCENARIOS)
def test_it_acts_legally_in_every_scenario_and_for_many_as_for_one(name):
    for step, views in enumerate(views_of(name)):
        view = views[step % len(views)]
        together = made().act_batch(view)
        assert np.isfinite(together).all()
        assert (np.abs(together) <= 1.0).all()
        row = step % len(together)
        alone = made().act(View(view.observations[row].tolist(), [], view.limits))
        np.testing.assert_allclose(alone, together[row], atol=1e-9)


def test_its_work_is_bounded_by_what_can_be_in_view_and_not_by_time(monkeypatch):
    """The same number of steps of the light arena, of the same sizes at most, whatever is in view."""
    sizes, steps = [], []
    drive = RolloutArena._drive
    monkeypatch.setattr(
        RolloutArena,
        "_drive",
        lambda self, dx, dy, drives: (sizes.append(self.distance.size), drive(self, dx, dy, drives)),
    )
    for name in ("standard", "crowd", "scarce", "capstone"):
        for views in views_of(name, steps=4, rows=1):
            begun = len(sizes)
            for view in views:
                made().act_batch(view)
                steps.append(len(sizes) - begun)
                begun = len(sizes)
    assert set(steps) == {Weights().steps}
    places, hunters, targets = 8 + 1 + 9, 1 + 7, 8
    assert max(sizes) <= places * hunters * targets


def test_what_is_not_in_view_changes_nothing():
    """Two arenas that differ in their seeds, and so in all that is to come, and in who stands out of view."""
    config = scenario("fog", control="velocity")
    seen = []
    for seed, hidden in ((1, 9.0), (2, 10.5)):
        arena = VectorArena(config, 1)
        arena.reset(seed=seed)
        hunters = [(2.0, 2.0, 0.3, 1.0), (3.0, 3.0, 1.0, 2.0), (hidden, 9.0, 0.0, 2.0), (9.0, hidden, 0.0, 2.0)]
        observations, _ = arena.place([hunters], [[(3.0, 1.5, 0.0, 0.0, 1.0), (hidden, 8.0, 0.0, 0.0, 2.0)]], steps=30)
        view = BatchView(observations[:, 0].copy(), np.zeros((1, 0), np.int8), Limits.of(config))
        seen.append(made().act_batch(view))
    np.testing.assert_array_equal(*seen)


def test_it_passes_over_what_is_as_good_as_caught_and_goes_on_to_the_next():
    scene = scene_of([(5.0, 5.0, 0.0)], [(5.2, 5.0), (5.0, 7.0)])
    assert scene.open[0, :2].tolist() == [False, True]
    assert look_ahead(scene, Weights())[0, 0] == -np.inf


def test_it_leaves_a_race_that_it_loses_for_one_that_it_wins():
    # a rival is nearer to what lies ahead; what lies aside is the hunter's own, if it does not lose time
    rivals = [(8.5, 5.0, np.pi), (7.9, 7.5, np.pi)]
    scene = scene_of([(5.0, 5.0, 0.7), *rivals], [(7.0, 5.0), (5.0, 7.5)])
    assert look_ahead(scene, Weights())[0].argmax() == 1


def scene_of(hunters, targets):
    """Hunters at x, y, heading, the first of which looks, and targets at x, y."""
    count = 4
    arena = VectorArena("standard", 1, control="velocity", copy=True)
    arena.reset(seed=1)
    bodies = [(*hunter, 1.0) for hunter in hunters] + [(np.nan,) * 4] * (count - len(hunters))
    standing = np.array([[(x, y, 0.0, 0.0, 0.0) for x, y in targets]]).reshape(1, len(targets), 5)
    observations, _ = arena.place([bodies], standing)
    return Scene.of(BatchView(observations[:, 0], np.zeros((1, 0), np.int8), Limits.of(arena.config)))


def test_team_mates_are_no_rivals_of_it():
    config = scenario("pairs", control="velocity")
    arena = VectorArena(config, 1, copy=True)
    seen, _ = arena.reset(seed=2)
    scene = Scene.of(BatchView(seen[:, 0], np.zeros((1, 0), np.int8), Limits.of(config)))
    assert scene.mates.sum() == 2
    mate = int(np.flatnonzero(scene.mates[0])[1])
    arena = RolloutArena(scene, Weights())
    assert arena.worth[0, [0, mate]].tolist() == [1.0, 1.0]
    assert (arena.worth[0] < 0).sum() == 2


@pytest.mark.parametrize(("side_m", "radius_m", "points"), [(20.0, 1.5, 64), (11.1, 0.5, 144), (20.0, 2.6, 16)])
def test_it_drives_on_over_the_whole_arena_while_it_sees_nothing(side_m, radius_m, points):
    """Around a closed way, from which all but the corners comes into view."""
    limits = Limits.of(scenario("haze", side_m=side_m, view_radius_m=radius_m))
    assert not circle_is_enough(limits)
    scene = scene_of([(5.0, 5.0, 0.0)], [])._replace(limits=limits)
    spots = np.random.default_rng(1).uniform(0.0, side_m, (2, 1000))
    way = [np.array([0.9 * side_m, 0.1 * side_m])]
    for _ in range(points + 1):
        x, y = way[-1].reshape(2, 1, 1)
        way.append(np.concatenate(on_the_lanes(scene._replace(x=x, y=y))))
    assert (way[1] == way[-1]).all()
    assert len({tuple(place) for place in way[1:]}) == points
    shown = np.zeros(1000, bool)
    for begin, end in pairwise(way[1:]):
        for place in np.linspace(begin, end, 10):
            shown |= np.hypot(*(spots - place[:, None])) < radius_m
    assert shown.mean() > 0.97


def test_where_a_circle_shows_most_of_the_arena_it_drives_on_the_circle():
    for name in ("fog", "blinkers", "standard"):
        assert circle_is_enough(Limits.of(scenario(name)))


def test_it_beats_nearest_over_a_few_matches():
    config = scenario("duel", time_limit_s=30)
    ahead = 0
    for seed in range(4):
        policies = [made(), Nearest()] if seed % 2 else [Nearest(), made()]
        result = play_match(config, seed, policies, ["one", "other"])
        ahead += (result.scores[0] - result.scores[1]) * (1 if seed % 2 else -1)
    assert ahead > 0
