"""Prey plays in a batch as it does in an env of its own."""

import numpy as np
import pytest

import catch_arena
from catch_arena.errors import AgentError
from catch_arena.policy import PreyLimits
from catch_arena.tournament.agent_spec import resolve_spec
from catch_arena.tournament.loading import create_policy
from catch_arena.training import LearnerBatch

WORDS = {0: "target", 1: "velocity"}


class Twins:
    """The arenas of a batch once more, as envs of one arena with prey of their own."""

    def __init__(self, batch, prey):
        kinds = batch.arena._engine.controls.tolist()
        self.batch, self.limits = batch, PreyLimits.of(batch.config)
        self.envs = [
            catch_arena.parallel_env(batch.config, control=tuple(WORDS[kind] for kind in row)) for row in kinds
        ]
        seeds = batch.arena.seeds().tolist()
        self.seen = [env.reset(seed=seed)[0] for env, seed in zip(self.envs, seeds, strict=True)]
        spec, names = resolve_spec(prey), batch.config.prey_names
        self.prey = [{name: create_policy(spec, "prey") for name in names} for _ in self.envs]
        for one in (one for own in self.prey for one in own.values()):
            one.reset(0)

    def step(self, seats):
        """Return observations and rewards of the learners in these seats, with the batch's own actions of hunters."""
        seen, earned = [], []
        for arena, (env, prey) in enumerate(zip(self.envs, self.prey, strict=True)):
            actions = {
                name: np.array(one.act(self.limits.view(self.seen[arena][name].tolist(), ())), np.float32)
                for name, one in prey.items()
            }
            for seat, word in enumerate(env.config.controls):
                rank, command = int(self.batch._choices[arena, seat]), self.batch._commands[arena, seat]
                actions[f"hunter_{seat}"] = {"target": rank, "velocity": command}[word]
            self.seen[arena], rewards, *_ = env.step(actions)
            seen += [self.seen[arena][f"hunter_{seat}"] for seat in seats[arena]]
            earned += [np.float32(rewards[f"hunter_{seat}"]) for seat in seats[arena]]
        return seen, earned


@pytest.mark.parametrize("prey", ["flee", "corners"])
@pytest.mark.parametrize(("scenario", "opponents"), [("tag", "nearest"), ("herd", ["first", "patrol"])])
def test_a_batch_with_prey_plays_what_one_arena_envs_play(scenario, opponents, prey):
    """Prey, which has an instance of its own in each arena, commands the same; the learners see, earn and catch the
    same, from episode to episode.
    """
    batch = LearnerBatch(
        scenario, 5, opponents=opponents, learners=2, prey_agent=prey, control="velocity", reach_m=1.5, max_cycles=40
    )
    batch.reset(seed=4)
    rng = np.random.default_rng(0)
    for _ in range(2):
        twins, seats = Twins(batch, prey), batch.seats
        for step in range(40):
            result = batch.step(rng.uniform(-1.0, 1.0, (10, 2)).astype(np.float32))
            seen, earned = twins.step(seats)
            assert result.rewards.tolist() == earned
            assert ((result.observations if step < 39 else result.final_observations) == seen).all()
        worlds = [env.world() for env in twins.envs]
        scores = [world.hunters[seat].score for world, own in zip(worlds, seats, strict=True) for seat in own]
        assert result.figures["score"].tolist() == scores
        assert any(one.times_caught for world in worlds for one in world.prey)


HAND_IN = """
import os

def fails(fault):
    return os.environ.get("CATCH_ARENA_TEST_FAULT") == fault

class Agent:
    def reset(self, seed): ...
    def act(self, view):
        return 0

class Prey:
    def reset(self, seed):
        if fails("reset"):
            raise ValueError("no")
    def act(self, view):
        if fails("act"):
            raise ValueError("no")
        return (2.0 if fails("answer") else 1.0), 0.0
    def __deepcopy__(self, memo):
        raise ValueError("no")
"""


@pytest.mark.parametrize(
    ("fault", "play", "message"),
    [
        ("reset", lambda batch: batch.reset(seed=2), "reset raised ValueError: no for prey_0 in arena 0"),
        ("act", lambda batch: batch.step(np.zeros((6, 2))), "act raised ValueError: no for prey_0 in arena 0"),
        (
            "answer",
            lambda batch: batch.step(np.zeros((6, 2))),
            "an action must be two numbers .* for prey_0 in arena 0",
        ),
        ("copy", LearnerBatch.save, "copying the agent raised ValueError: no"),
        ("copy", LearnerBatch.clone, "copying the agent raised ValueError: no"),
    ],
)
def test_prey_that_fails_is_named_in_one_line(tmp_path, monkeypatch, fault, play, message):
    """The line names its place, and nothing has moved."""
    file = tmp_path / "mine.py"
    file.write_text(HAND_IN)
    batch = LearnerBatch("tag", 2, prey_agent=str(file))
    batch.reset(seed=1)
    before = batch.arena.digest(0)
    monkeypatch.setenv("CATCH_ARENA_TEST_FAULT", fault)
    with pytest.raises(AgentError, match=rf"prey .*mine\.py:? {message}") as caught:
        play(batch)
    assert "\n" not in str(caught.value)
    assert fault == "reset" or batch.arena.digest(0) == before


def test_an_agent_without_a_prey_is_refused():
    """`patrol` has none."""
    with pytest.raises(AgentError, match="patrol"):
        LearnerBatch("tag", 2, prey_agent="patrol")
