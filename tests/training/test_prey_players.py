"""Prey of a batch of learners is called, copied, named when it fails, and goes on from a saved state."""

import numpy as np
import pytest

from catch_arena.errors import AgentError
from catch_arena.layout import prey_observation_size
from catch_arena.policy import PreyLimits
from catch_arena.training import LearnerBatch


class Counting:
    """Prey that counts its calls, drives what it is given, and remembers its seeds."""

    def __init__(self, answer=None):
        self.answer, self.views, self.seeds = answer, [], []

    def reset(self, seed):
        self.seeds.append(seed)

    def act_batch(self, view):
        self.views.append(view)
        commands = np.tile((len(self.views) % 3 / 4, 0.5), (len(view.observations), 1))
        return commands if self.answer is None else self.answer(commands)


def hold(batch):
    return np.zeros((batch.num_rows, 2))


def test_prey_with_act_batch_is_called_once_a_step_for_the_prey_of_all_arenas():
    """One instance through the ends of episodes, seeded when all are reset; its view has what single views have."""
    prey = Counting()
    batch = LearnerBatch("herd", 3, prey_agent=prey, max_cycles=2, control="velocity")
    batch.reset(seed=1)
    batch.reset(arenas=[1])
    size, limits = prey_observation_size(batch.config), PreyLimits.of(batch.config)
    rows = batch._batch.observations[:, 4:, :size].reshape(12, -1).copy()
    for _ in range(5):
        batch.step(hold(batch))
    assert (len(prey.views), len(prey.seeds)) == (5, 1)
    assert (batch._commands[:, 4:] == np.float32((0.5, 0.5))).all()
    (view, *_), singles = prey.views, [limits.view(row, ()) for row in rows.tolist()]
    assert view.limits == limits
    assert view.observations.tolist() == rows.tolist()
    assert view.own.x.tolist() == [one.x for one in singles]
    assert view.own.alive.tolist() == [one.alive for one in singles]
    for name in ("hunters", "others"):
        table = np.stack([column for key, column in getattr(view, name)._asdict().items() if key != "present"], axis=-1)
        assert table.tolist() == [[list(body[1:]) for body in getattr(one, name)] for one in singles]
        assert (getattr(view, name).present == 1).all()


def test_prey_is_a_class_or_an_object_too():
    """An object with `act_batch` plays itself; one with `act` is copied for each prey, and begins with each episode."""

    class Alone:
        def reset(self, _seed):
            self.calls = 0

        def act(self, _view):
            self.calls += 1
            return self.calls / 10, 0.0

    for prey in (Alone, Alone(), Counting):
        batch = LearnerBatch("herd", 2, prey_agent=prey, control="velocity", max_cycles=2)
        batch.reset(seed=1)
        for _ in range(4):
            batch.step(hold(batch))
        assert (batch._commands[:, 4:, 0] == np.float32(0.25 if prey is Counting else 0.2)).all()


def with_row(row, value):
    """Make an answer that is wrong in one row."""

    def answer(commands):
        commands[row] = value
        return commands

    return answer


class Alone:
    """Prey that acts for itself, outside of the bounds."""

    def reset(self, seed):
        """Begin."""

    def act(self, _view):
        return 2.0, 0.0


@pytest.mark.parametrize(
    ("prey", "message"),
    [
        (Alone, r"prey Alone: an action must be two numbers in \[-1, 1\], got \(2.0, 0.0\) for prey_0 in arena 0"),
        (
            Counting(with_row(6, (0.0, 1.5))),
            r"prey Counting: actions must be numbers in \[-1, 1\], got \[0.0, 1.5\] for prey_2 in arena 1",
        ),
        (Counting(with_row(3, (np.nan, 0.0))), r"got \[nan, 0.0\] for prey_3 in arena 0"),
    ],
)
def test_prey_that_fails_is_named_in_one_line(prey, message):
    """With its arena and number; nothing has moved. `test_opponents.py` has the other mistakes."""
    batch = LearnerBatch("herd", 2, prey_agent=prey, control="velocity")
    batch.reset(seed=1)
    before = [batch.arena.digest(arena) for arena in range(2)]
    with pytest.raises(AgentError, match=message) as caught:
        batch.step(hold(batch))
    assert "\n" not in str(caught.value)
    assert [batch.arena.digest(arena) for arena in range(2)] == before


def test_prey_that_acts_for_many_goes_on_from_a_saved_state():
    batch = LearnerBatch("herd", 2, prey_agent=Counting(), control="velocity")
    batch.reset(seed=1)
    batch.step(hold(batch))
    saved, twin = batch.save(), batch.clone()

    def played(one):
        return [one.step(hold(one)).observations.tolist() for _ in range(4)]

    expected = played(batch)
    batch.restore(saved)
    assert played(batch) == played(twin) == expected


def test_an_agent_without_a_prey_is_refused():
    """`patrol` has none."""
    with pytest.raises(AgentError, match="patrol"):
        LearnerBatch("tag", 2, prey_agent="patrol")
