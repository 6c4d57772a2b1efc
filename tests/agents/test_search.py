"""The agent that looks ahead: what it sees, what it decides, and how much work it does."""

import numpy as np
import pytest

from catch_arena import SCENARIOS, Limits, VectorArena, View, scenario
from catch_arena.agents.nearest import Agent as Nearest
from catch_arena.agents.search import Agent, RolloutArena, Scene, Weights, drive_to, look_ahead
from catch_arena.batch_policy import BatchView
from catch_arena.layout import observation_size
from catch_arena.tournament.match_loop import play_match


def made():
    agent = Agent()
    agent.reset(1)
    return agent


def views_of(name, steps=12, rows=3):
    """What all hunters of some arenas see, after each step, while they look ahead."""
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


def test_of_places_to_wait_it_prefers_those_that_give_it_ground():
    # the rivals are about the middle, ahead; with nothing in view the hunter keeps behind them, or goes past
    scene = scene_of([(2.0, 5.5, 0.0), (5.0, 4.5, 0.0), (5.0, 5.5, 0.0), (5.0, 6.5, 0.0)], [])
    worth = look_ahead(scene, Weights())[0]
    outwards = np.hypot(scene.goal_x[0] - 0.5, scene.goal_y[0] - 5.5).argmin()
    inwards = np.hypot(scene.goal_x[0] - 5.5, scene.goal_y[0] - 5.5).argmin()
    assert worth[inwards] > worth[outwards]
    arena = RolloutArena(scene, Weights())
    assert 0.0 < arena.own_ground()[0, 0] < 0.5


def scene_of(hunters, targets):
    """Hunters at x, y, heading, the first of which looks, and targets at x, y."""
    count = 4
    arena = VectorArena("standard", 1, control="velocity", copy=True)
    arena.reset(seed=1)
    bodies = [(*hunter, 1.0) for hunter in hunters] + [(np.nan,) * 4] * (count - len(hunters))
    standing = np.array([[(x, y, 0.0, 0.0, 0.0) for x, y in targets]]).reshape(1, len(targets), 5)
    observations, _ = arena.place([bodies], standing)
    return Scene.of(BatchView(observations[:, 0], np.zeros((1, 0), np.int8), Limits.of(arena.config)))


def test_the_light_arena_plays_much_as_the_engine_does():
    """A hunter alone on its way to a target: both arrive within a step or two of the light arena's."""
    rng = np.random.default_rng(3)
    for _ in range(8):
        x, y, heading, there_x, there_y = rng.uniform([2, 2, -3, 2, 2], [9, 9, 3, 9, 9])
        if np.hypot(x - there_x, y - there_y) < 0.5:
            continue
        scene = scene_of([(x, y, heading)], [(there_x, there_y)])
        light, steps = RolloutArena(scene, Weights()), 0
        while light.alive[0, 0, 0]:
            light.catch()
            light.move(waits=False)
            steps += 1
        arena = VectorArena("standard", 1, control="velocity", spawning=False, initial_targets=1)
        arena.reset(seed=1)
        bodies = [[(x, y, heading, 1.0)] + [(np.nan,) * 4] * 3]
        seen, _ = arena.place(bodies, [[(there_x, there_y, 0.0, 0.0, 0.0)]])
        played = 0
        while True:
            view = BatchView(seen[:, 0], np.zeros((1, 0), np.int8), Limits.of(arena.config))
            commands = np.zeros((1, 4, 2), np.float32)
            its = Scene.of(view)
            commands[:, 0] = drive_to(its, np.zeros(1, np.intp))
            seen, rewards, *_ = arena.step(commands=commands)
            played += 1
            if rewards[0, 0]:
                break
        assert abs(0.2 * steps - 0.1 * played) <= 0.45


def chased(scenario, target):
    """A hunter at (2, 2) that faces along the diagonal drives to a target: for how long it expects to [s], and how long
    it takes in the engine.
    """
    arena = VectorArena(scenario, 1, control="velocity", spawning=False, initial_targets=1)
    arena.reset(seed=1)
    seen, _ = arena.place([[(2.0, 2.0, np.pi / 4, 1.0)] + [(np.nan,) * 4] * 3], [[(*target, 0.0, 0.0)]])
    limits, expected = Limits.of(arena.config), None
    for step in range(1, 100):
        scene = Scene.of(BatchView(seen[:, 0], np.zeros((1, 0), np.int8), limits))
        if expected is None:
            expected = RolloutArena(scene, Weights())._races_s()[0, 0, 0, 0]
        commands = np.zeros((1, 4, 2), np.float32)
        commands[:, 0] = drive_to(scene, np.zeros(1, np.intp))
        seen, rewards, *_ = arena.step(commands=commands)
        if rewards[0, 0]:
            return expected, step / 10
    raise AssertionError("it was not caught")


@pytest.mark.parametrize("away", [0.6, 1.2, 1.8, 2.6])
def test_it_knows_how_long_a_target_that_flees_takes(away):
    """It gains by the difference of both speeds alone as soon as the target flees (R3.10)."""
    place = 2.0 + away / 2**0.5
    expected, took = chased("evasive", (place, place, np.pi / 4))
    assert took == pytest.approx(expected, abs=0.35)


def test_it_meets_what_drives_by():
    """In the light arena all drive ahead of a target, not behind it."""
    arena = VectorArena("wander", 1, control="velocity", copy=True)
    arena.reset(seed=1)
    seen, _ = arena.place([[(3.0, 3.0, 0.0, 1.0)] + [(np.nan,) * 4] * 3], [[(5.0, 3.0, np.pi / 2, 1.0, 0.0)]])
    light = RolloutArena(Scene.of(BatchView(seen[:, 0], np.zeros((1, 0), np.int8), Limits.of(arena.config))), Weights())
    x, y = light.meet_x, light.meet_y
    assert x[0, 0, 0, 0] == pytest.approx(5.0, abs=0.01)
    assert y[0, 0, 0, 0] == pytest.approx(4.0, abs=0.01)  # R3.9: a metre a second, for the second that it takes
    light.move(waits=True)
    assert light.heading[0, 0, 0] == pytest.approx(np.arctan2(1.0, 2.0), abs=0.02)


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


def test_it_beats_nearest_over_a_few_matches():
    config = scenario("duel", time_limit_s=30)
    ahead = 0
    for seed in range(4):
        policies = [made(), Nearest()] if seed % 2 else [Nearest(), made()]
        result = play_match(config, seed, policies, ["one", "other"])
        ahead += (result.scores[0] - result.scores[1]) * (1 if seed % 2 else -1)
    assert ahead > 0


def test_its_limits_may_be_any():
    config = scenario("unequal", control="velocity", reverse=True)
    limits = Limits.of(config, 3)
    arena = VectorArena(config, 1, copy=True)
    seen, _ = arena.reset(seed=2)
    commands = made().act_batch(BatchView(seen[:, 3], np.zeros((1, 0), np.int8), limits))
    assert (np.abs(commands) <= 1.0).all()
