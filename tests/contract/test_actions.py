"""An action is legal or not by one rule, wherever an agent plays."""

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import odd_actions
import pytest
from odd_actions import FORMS, NO_RANK, RANK_1, Arrayed, Index, Listed

from catch_arena import VectorArena, env, parallel_env, scenario
from catch_arena.errors import ActionError, AgentError
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.match_loop import play_entrants, play_match
from catch_arena.tournament.players import enter
from catch_arena.training import LearnerBatch

SEED = 5
DUEL = scenario("duel")


def outcome(call):
    """The digest after a step that plays an action; None for one that is refused."""
    try:
        return call()
    except (ActionError, AgentError):
        return None


def in_parallel(control, *actions):
    arena = parallel_env(DUEL, control=control)
    arena.reset(seed=SEED)
    arena.step(dict(zip(arena.agents, actions, strict=True)))
    return arena.digest()


def in_turns(control, *actions):
    arena = env(DUEL, control=control)
    arena.reset(seed=SEED)
    for action in actions:
        arena.step(action)
    return arena.digest()


def in_a_batch(*actions, **settings):
    arena = VectorArena(DUEL, 1, **settings)
    arena.reset(seed=[SEED])
    arena.step(*actions)
    return arena.digest(0)


def by_learners(actions, **settings):
    batch = LearnerBatch(DUEL, 1, **settings)
    batch.reset(seed=SEED)
    batch.step(actions)
    return batch.arena.digest(0)


class Means:
    def __init__(self, form=0):
        self.form = form

    def reset(self, seed):
        pass

    def act(self, _view):
        return self.form


class MeansInBatches(Means):
    def act_batch(self, _view):
        return [self.form]  # of the one hunter that it plays


PLAYED = {
    "parallel": lambda form: in_parallel("target", form, 0),
    "parallel, full control": lambda form: in_parallel(("full", "target"), {"cmd_vel": (1.0, 0.0), "catch": form}, 0),
    "turns": lambda form: in_turns("target", form, 0),
    "batch": lambda form: in_a_batch([[form, 0]]),
    "batch, any control": lambda form: in_a_batch(((form, 0),), np.zeros((1, 2, 2)), any_control=True),
    "learner": lambda form: by_learners([form], opponents=Means()),
    "learners": lambda form: by_learners([form, 0]),
    "opponent": lambda form: by_learners([0], opponents=Means(form)),
    "opponent in batches": lambda form: by_learners([0], opponents=MeansInBatches(form)),
}
"""The digest after a step in which a hunter chooses this form of a rank, by environment."""


@pytest.mark.parametrize("name", [*RANK_1, *NO_RANK])
@pytest.mark.parametrize("played", PLAYED.values(), ids=PLAYED)
def test_a_form_of_a_rank_is_legal_in_every_environment_or_in_none(played, name):
    """Whatever `operator.index` takes, and an array or a tensor with one such element."""
    assert played(1) not in (None, played(0))
    assert outcome(lambda: played((RANK_1 | NO_RANK)[name])) == (played(1) if name in RANK_1 else None)


@pytest.mark.parametrize("level", ["trusted", "processes"])
def test_a_form_of_a_rank_is_legal_in_every_process_or_in_none(level):
    """An agent that forfeits in isolation forfeits with --trusted, and with the same sentence."""
    found = {}
    sandbox = None if level == "trusted" else Sandbox(replace(Quotas(init_s=60, step_ms=60_000), isolation=level))
    try:
        (entrant,) = enter([odd_actions.__file__], sandbox)
        entrants = [entrant, *enter(["idle"])]
        for seed, name in enumerate(RANK_1 | NO_RANK):
            result = play_entrants(DUEL, SEED, entrants, sandbox, agent_seeds=(seed, 0), most_steps=1)
            found[name] = result.digest if result.forfeit_codes[0] is None else result.forfeit_codes[0]
    finally:
        if sandbox:
            sandbox.close()

    assert found == dict.fromkeys(RANK_1, in_parallel("target", 1, 0).hex()) | dict.fromkeys(NO_RANK, "FORFEIT_ILLEGAL")
    assert len(found) == len(FORMS)


HALF = {
    "floats": (0.5, -1.0),
    "list": [0.5, -1],
    "array": np.array([0.5, -1.0]),
    "float32": np.array([0.5, -1.0], np.float32),
    "numbers of NumPy": (np.float32(0.5), np.int8(-1)),
    "fraction": (Fraction(1, 2), Index(-1)),
    "arrays without axes": (np.array(0.5), Listed(-1.0)),
    "tensor": Listed([0.5, -1.0]),
    "array-like": Arrayed([0.5, -1.0]),
}
CLIPPED = {
    "a little": (0.5, -1.0000001),
    "array": np.array([0.5, -1.5]),
    "far": [0.5, -1e300],
    "a whole number": (0.5, -7),
    "tensor": Listed([0.5, -7.0]),
}
NO_VELOCITY = {
    "nan": (0.5, math.nan),
    "infinity": (0.5, -math.inf),
    "infinite array": np.array([0.5, -np.inf]),
    "one": np.array([0.5]),
    "three": (0.5, -1.0, 0.0),
    "row": np.array([[0.5, -1.0]]),
    "column": np.array([[0.5], [-1.0]]),
    "text": ("0.5", "-1"),
    "booleans": (True, False),
    "boolean": (0.5, np.True_),
    "number": 0.5,
    "None": None,
    "complex": (0.5, -1j),
}


def driven(control, form):
    """The digest after one step, in each kind of environment; None where it is refused."""
    pairs = [form, (0.0, 0.0)]
    actions = pairs if control == "velocity" else [{"cmd_vel": pair, "catch": 0} for pair in pairs]
    of_learners = pairs if control == "velocity" else {"cmd_vel": pairs, "catch": [0, 0]}
    calls = (
        lambda: in_parallel(control, *actions),
        lambda: in_turns(control, *actions),
        lambda: in_a_batch([[0, 0]], [pairs], control=control),
        lambda: by_learners(of_learners, control=control),
    )
    return [outcome(call) for call in calls]


@pytest.mark.parametrize("control", ["velocity", "full"])
@pytest.mark.parametrize("name", HALF)
def test_a_velocity_may_be_any_two_real_numbers(control, name):
    assert driven(control, HALF[name]) == driven(control, (0.5, -1.0))
    assert None not in driven(control, HALF[name])


@pytest.mark.parametrize("control", ["velocity", "full"])
@pytest.mark.parametrize("name", CLIPPED)
def test_finite_velocities_out_of_bounds_are_clipped_by_the_environments(control, name):
    """mpe2 and pistonball clip too: a Gaussian policy draws such actions all the time."""
    assert driven(control, CLIPPED[name]) == driven(control, (0.5, -1.0))


@pytest.mark.parametrize("control", ["velocity", "full"])
@pytest.mark.parametrize("name", NO_VELOCITY)
def test_what_is_no_velocity_is_refused_and_not_clipped(control, name):
    assert driven(control, NO_VELOCITY[name]) == [None] * 4


def test_clipping_leaves_the_callers_array_as_it_was():
    """Prey's velocities are clipped too."""
    arena, twin = (VectorArena("tag", 2) for _ in range(2))
    hunters, agents = arena.num_hunters, arena.num_hunters + arena.num_prey
    given = np.full((2, agents, 2), 3.0, np.float32)
    given[:, hunters:] = -3.0
    for each in (arena, twin):
        each.reset(seed=1)
    arena.step(commands=given)
    twin.step(commands=given / 3)

    assert arena.digest(1) == twin.digest(1)
    assert (given[:, :hunters] == 3).all()
    assert (given[:, hunters:] == -3).all()


def test_an_agent_that_drives_out_of_bounds_forfeits_in_a_tournament():
    """A tournament keeps the rule that the environments relax."""
    for control, answer in (("velocity", (1.0000001, 0.0)), ("full", {"cmd_vel": (0.0, -1.5), "catch": 0})):
        driver = Means(answer)
        driver.control = control
        result = play_match(DUEL, SEED, [driver, Means()], ["driver", "idle"], most_steps=2)

        assert result.forfeit_codes == ("FORFEIT_ILLEGAL", None)
        assert "must be two numbers in [-1, 1], got" in result.forfeits[0].reason
