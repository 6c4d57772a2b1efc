"""Opponents in a batch are drawn by weight, play as in a match, and are named when they fail."""

from collections import Counter

import numpy as np
import pytest

import catch_arena
from catch_arena.batch_policy import BatchView
from catch_arena.errors import AgentError, ConfigError, EpisodeError
from catch_arena.policy import Limits, View
from catch_arena.training import LearnerBatch

WORDS = ("target", "velocity", "full")


class Fixed:
    """Acts alone, and remembers how often."""

    made = 0

    def reset(self, _seed):
        type(self).made += 1
        self.steps = 0

    def act(self, _view):
        self.steps += 1
        return self.steps % 2


class Full(Fixed):
    """Drives and asks."""

    control = "full"

    def act(self, view):
        return {"cmd_vel": (0.5, -0.25), "catch": super().act(view)}


class Unmade(Fixed):
    """Cannot even be made."""

    def __init__(self):
        raise ValueError("not\ntoday")


class BatchFixed:
    """Gives what it was made with."""

    def __init__(self, answer, control="target"):
        self.answer, self.control = answer, control

    def reset(self, seed):
        pass

    def act_batch(self, view):
        return self.answer(view) if callable(self.answer) else self.answer


def hold(batch):
    """Learners that do nothing."""
    return np.zeros(batch.num_rows, dtype=int)


def test_a_batch_view_names_what_a_view_names():
    """Column by column, of any shape of batch."""
    for scenario in ("standard", "evasive", "pairs"):
        config = catch_arena.scenario(scenario)
        arena = catch_arena.VectorArena(config, 5)
        arena.reset(seed=3)
        for _ in range(20):
            observations, *_, infos = arena.step(np.ones((5, config.hunters), dtype=int))
        view = BatchView(observations, infos["action_mask"], Limits.of(config))
        one = View(observations[2, 1].tolist(), infos["action_mask"][2, 1].tolist(), Limits.of(config))
        assert view.own.x.shape == (5, config.hunters)
        assert (view.own.x[2, 1], view.own.score[2, 1]) == (one.x, one.score)
        assert view.targets.present[2, 1].sum() == len(one.targets) > 1
        assert view.rivals.present[2, 1].sum() == len(one.rivals) > 0
        for rank, target in enumerate(one.targets):
            assert view.targets.forward[2, 1, rank] == target.forward
            assert view.targets.active[2, 1, rank] == target.active
            if config.targets_move:
                assert view.targets.linear_velocity[2, 1, rank] == target.linear_velocity
        for rank, rival in enumerate(one.rivals):
            assert view.rivals.heading_sin[2, 1, rank] == rival.heading_sin
            assert view.rivals.score_difference[2, 1, rank] == rival.score_difference
            if config.teams is not None:
                assert view.rivals.mate[2, 1, rank] == rival.mate
        assert np.shares_memory(view.targets.left, observations)


def quarter_speed(view):
    return np.full((len(view.observations), 2), 0.25)


def quarter_speed_and_catch(view):
    return {"cmd_vel": quarter_speed(view), "catch": np.ones(len(view.observations), dtype=int)}


HUNT = {"control": "target", "max_cycles": 40, "reach_m": 1.5}


@pytest.mark.parametrize(
    ("scenario", "opponents", "settings"),
    [
        ("standard", "nearest", {}),
        ("standard", ["nearest", "patrol"], {}),
        ("standard", Fixed, {}),
        ("standard", ["contested", BatchFixed(quarter_speed, "velocity")], {}),
        ("standard", [Full, BatchFixed(quarter_speed_and_catch, "full")], {}),
        ("tag", "nearest", HUNT),
        ("herd", ["first", "patrol"], HUNT | {"prey_agent": "corners"}),
    ],
)
def test_a_batch_with_opponents_plays_what_one_arena_envs_play(scenario, opponents, settings):
    """With the same actions, and each seat under the control of who sits there."""
    batch = LearnerBatch(scenario, 7, opponents=opponents, **{"max_cycles": 9} | settings)
    batch.reset(seed=4)
    hunters, steps = batch.config.hunters, batch.config.max_cycles
    rng = np.random.default_rng(0)
    for _ in range(2):
        kinds = batch.arena._engine.controls.copy()
        configs = [batch.config.replace(control=tuple(WORDS[k] for k in row)) for row in kinds.tolist()]
        envs = [catch_arena.parallel_env(config) for config in configs]
        for env, seed in zip(envs, batch.arena.seeds().tolist(), strict=True):
            env.reset(seed=seed)
        for step in range(steps):
            seats = batch.seats[:, 0]
            actions = rng.integers(0, batch.config.targets_seen + 1, 7)
            expected = []
            result = batch.step(actions)
            for row, env in enumerate(envs):
                actions_by_name = dict(zip(batch.config.prey_names, batch._commands[row, hunters:], strict=True))
                for seat, word in enumerate(configs[row].controls):
                    rank, command = int(batch._choices[row, seat]), batch._commands[row, seat]
                    full = {"cmd_vel": command, "catch": rank}
                    actions_by_name[f"hunter_{seat}"] = {"target": rank, "velocity": command, "full": full}[word]
                assert actions_by_name[f"hunter_{seats[row]}"] == actions[row]
                observations, rewards, *_ = env.step(actions_by_name)
                expected.append(observations[f"hunter_{seats[row]}"])
                assert result.rewards[row] == np.float32(rewards[f"hunter_{seats[row]}"])
            if step < steps - 1:
                assert (result.observations == np.array(expected)).all()
        assert result.ended.tolist() == list(range(7))
        assert (result.final_observations == np.array(expected)).all()
        assert result.truncations.all()
        worlds = [env.world() for env in envs]
        scores = [world.hunters[seat].score for world, seat in zip(worlds, seats, strict=True)]
        assert result.figures["score"].tolist() == scores
        assert any(one.times_caught for world in worlds for one in world.prey) == bool(batch.config.prey)


def test_learners_move_on_by_a_seat_and_opponents_are_drawn_anew_in_each_episode():
    """Arenas begin at different seats, and agents come as often as their weights say."""
    batch = LearnerBatch("standard", 4, opponents={"nearest": 3, "patrol": 1, "idle": 0}, learners=2, max_cycles=1)
    batch.reset(seed=1)
    seats, met = [batch.seats], Counter()
    for _ in range(200):
        batch.step(hold(batch))
        seats.append(batch.seats)
        met.update(batch.opponents.seated[batch.opponents.seated >= 0].tolist())

    assert seats[0].tolist() == [[0, 1], [1, 2], [2, 3], [3, 0]]
    assert seats[1].tolist() == [[1, 2], [2, 3], [3, 0], [0, 1]]
    assert (seats[4] == seats[0]).all()
    assert batch.opponents.names == ("nearest", "patrol", "idle")
    assert met[2] == 0
    assert met[0] / sum(met.values()) == pytest.approx(0.75, abs=0.05)


def nonsense(shape, value, row=2):
    """Right but for one row."""

    def answer(view):
        given = np.zeros((len(view.observations), *shape), dtype=np.asarray(value).dtype)
        given[row] = value
        return given

    return answer


def out_of_ideas(_view):
    """A stranger's mistake."""
    raise IndexError("no more\nideas")


RAISES = BatchFixed(out_of_ideas)


@pytest.mark.parametrize(
    ("opponent", "message"),
    [
        (RAISES, "opponent BatchFixed: act_batch raised IndexError: no more ideas"),
        (BatchFixed(nonsense((), 9)), "actions must be numbers in \\[0, 8\\], got 9 for hunter_1 in arena 2"),
        (BatchFixed(nonsense((), -1)), "actions must be numbers in \\[0, 8\\], got -1 for hunter_1 in arena 2"),
        (
            BatchFixed(nonsense((), 1.0)),
            r"actions must be whole numbers of the shape \(3,\), got an array of float64 of the shape",
        ),
        (BatchFixed(None), r"opponent BatchFixed: actions must be whole numbers of the shape \(3,\), got None"),
        (BatchFixed([1, 2]), r"actions must be whole numbers of the shape \(3,\), got \[1, 2\]"),
        (BatchFixed([[1], [1, 2]]), r"actions must be whole numbers of the shape \(3,\), got \[\[1\], \[1, 2\]\]"),
        (BatchFixed(nonsense((2,), [np.nan, 0.0]), "velocity"), r"got \[nan, 0.0\] for hunter_1 in arena 2"),
        (BatchFixed(nonsense((2,), [0.0, 1.5]), "velocity"), r"got \[0.0, 1.5\] for hunter_1 in arena 2"),
        (
            BatchFixed(np.zeros(3), "velocity"),
            r"actions must be numbers of the shape \(3, 2\), got an array of float64 of the shape \(3,\)",
        ),
        (BatchFixed(np.zeros(3), "full"), "actions must be a mapping with cmd_vel and catch, got"),
    ],
)
def test_an_opponent_that_raises_or_answers_nonsense_in_one_row_is_told_in_one_line(opponent, message):
    """With its name, and where it is one row the arena and the hunter; nothing has moved."""
    batch = LearnerBatch("duel", 3, opponents=opponent)
    batch.reset(seed=1)
    before = [batch.arena.digest(row) for row in range(3)]
    with pytest.raises(AgentError, match=message) as caught:
        batch.step(hold(batch))
    assert "\n" not in str(caught.value)
    assert [batch.arena.digest(row) for row in range(3)] == before


@pytest.mark.parametrize(
    ("control", "answer", "message"),
    [
        ("target", 9, "opponent Says: an action must be a whole number from 0 to 8, got 9 for hunter_1 in arena 0"),
        (
            "velocity",
            (0.0, 1.5),
            r"an action must be two numbers in \[-1, 1\], got \(0.0, 1.5\) for hunter_1 in arena 0",
        ),
        ("full", 3, "an action must be a mapping with cmd_vel and catch, got 3 for hunter_1 in arena 0"),
    ],
)
def test_the_answer_of_an_agent_that_acts_alone_is_judged_as_in_one_arena(control, answer, message):
    """The error has the same words, with the agent's name and place."""

    class Says(Fixed):
        def act(self, _view):
            return answer

    Says.control = control
    batch = LearnerBatch("duel", 3, opponents=Says)
    batch.reset(seed=1)
    before = batch.arena.digest(0)
    with pytest.raises(AgentError, match=message):
        batch.step(hold(batch))
    assert batch.arena.digest(0) == before


def test_after_an_opponent_that_cannot_begin_an_episode_all_must_be_reset():
    """Seats would be without a player."""

    class Tires(Fixed):
        def reset(self, _seed):
            if Tires.made == 4:
                raise ValueError("tired")
            super().reset(_seed)

    Tires.made = 0
    batch = LearnerBatch("duel", 3, opponents=Tires, max_cycles=2)
    batch.reset(seed=1)
    batch.step(hold(batch))
    with pytest.raises(AgentError, match="opponent Tires: reset raised ValueError: tired for hunter_1 in arena 1"):
        batch.step(hold(batch))
    for call in (lambda: batch.step(hold(batch)), lambda: batch.reset(arenas=[0]), batch.save):
        with pytest.raises(EpisodeError, match="was called before the first reset"):
            call()
    Tires.made = 0
    batch.reset(seed=1)
    batch.step(hold(batch))


@pytest.mark.parametrize(
    ("pool", "message"),
    [
        ([], r"opponents must name at least one agent, got \[\]"),
        ({}, "opponents must name at least one agent"),
        (
            {"nearest": 0.0},
            "weights of opponents must be 1 finite numbers of at least 0, of which at least one is positive",
        ),
        ({"nearest": -1, "patrol": 2}, "weights of opponents must be 2 finite numbers of at least 0"),
        ({"nearest": "often"}, "weights of opponents must be"),
    ],
)
def test_a_pool_that_is_empty_or_has_bad_weights_is_refused(pool, message):
    """In one line."""
    with pytest.raises(ConfigError, match=message):
        LearnerBatch("duel", 2, opponents=pool)


@pytest.mark.parametrize(
    ("opponent", "message"),
    [
        ("nearst", "nearst"),
        (3, "opponent int: must have the methods reset and act_batch, or reset and act, but has no reset"),
        (Unmade, r"opponent Unmade: Unmade\(\) raised ValueError: not today"),
    ],
)
def test_an_agent_that_is_none_is_refused(opponent, message):
    """By name, as an object, and as a class."""
    with pytest.raises(AgentError, match=message):
        LearnerBatch("duel", 2, opponents=opponent)


def test_distinct_opponents_are_drawn_by_their_weights_and_never_twice():
    """With fewer agents than seats they repeat."""
    batch = LearnerBatch(
        "standard", 600, opponents={"nearest": 1, "first": 1, "idle": 4, "contested": 1}, distinct=True
    )
    batch.reset(seed=3)
    seated = batch.opponents.seated
    assert all(len(set(row[row >= 0].tolist())) == 3 for row in seated)
    met = [int((seated == number).any(axis=1).sum()) for number in range(4)]
    assert met[2] > 560  # seven times in ten it is drawn first
    assert all(350 < times < 470 for times in (met[0], met[1], met[3]))
    few = LearnerBatch("standard", 4, opponents=["nearest", "first"], distinct=True)
    few.reset(seed=3)
    assert few.opponents.seated.max() <= 1
    with pytest.raises(ConfigError, match="distinct must be true or false"):
        LearnerBatch("standard", 4, opponents="nearest", distinct=2)


def test_a_pool_that_grows_is_drawn_from_once_it_has_a_weight():
    """Episodes that have begun keep their opponents."""
    batch = LearnerBatch("duel", 40, opponents="nearest", max_cycles=3)
    batch.reset(seed=1)
    number = batch.opponents.add("patrol")
    assert (number, batch.opponents.names) == (1, ("nearest", "patrol"))
    assert batch.opponents.weights.tolist() == [1, 0]
    for _ in range(6):
        step = batch.step(hold(batch))
    assert (batch.opponents.seated != 1).all()
    batch.opponents.weigh([0, 2])
    assert (batch.opponents.seated != 1).all()
    for _ in range(3):
        step = batch.step(hold(batch))
    assert step.figures["opponents"].tolist() == [[0]] * 40
    assert (batch.opponents.seated.max(axis=1) == 1).all()
    for wrong in ([1], [0, 0], [1, float("nan")], [-1, 2], [1, "often"], "often"):
        with pytest.raises(ConfigError, match="weights"):
            batch.opponents.weigh(wrong)


def test_the_figures_of_an_episode_name_its_opponents_and_their_scores():
    """Beside the learner's own, seat by seat."""
    batch = LearnerBatch("standard", 6, opponents=["nearest", "patrol"], max_cycles=40, learners=2)
    batch.reset(seed=5)
    who = batch.opponents.seated
    for _ in range(40):
        seats = batch.seats
        step = batch.step(hold(batch))
    assert step.ended.tolist() == list(range(12))
    assert step.figures["opponents"].shape == step.figures["opponent_scores"].shape == (12, 2)
    for arena in range(6):
        wanted = [who[arena, seat] for seat in range(4) if seat not in seats[arena]]
        assert (
            step.figures["opponents"][2 * arena].tolist() == step.figures["opponents"][2 * arena + 1].tolist() == wanted
        )
    assert step.figures["opponent_scores"].sum() > 0
    assert step.figures["score"].sum() == 0  # who holds catches nothing


def test_a_run_is_repeated_by_its_seed():
    """Opponents, seats and what opponents rng."""
    runs = []
    for _ in range(2):
        batch = LearnerBatch("standard", 5, opponents=["random", "patrol", "nearest"], max_cycles=4)
        batch.reset(seed=6)
        runs.append([batch.step(hold(batch)).observations.tobytes() for _ in range(12)])
        batch.reset(seed=6)
        runs.append([batch.step(hold(batch)).observations.tobytes() for _ in range(12)])

    assert all(run == runs[0] for run in runs)
