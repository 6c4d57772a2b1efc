"""Batches in which every hunter and prey has a player play what arenas without players do."""

import numpy as np
import pytest

import catch_arena
from catch_arena import Limits, PreyLimits, VectorArena, View, scenario
from catch_arena.core.controllers import CONTROLS
from catch_arena.engine.episode_seeds import batch_seeds
from catch_arena.errors import ActionError, AgentError, ConfigError, EpisodeError
from catch_arena.layout import prey_columns
from catch_arena.policy import control_of
from catch_arena.tournament.agent_spec import resolve
from catch_arena.tournament.loading import create_policy
from catch_arena.training.player_batch import PlayerBatch, play_matches
from catch_arena.training.players import LEARNER

SHORT = {"max_cycles": 25, "reach_m": 1.0}
TWO_SIDES = {"hunter": ["intercept", "nearest"], "prey": ["flee"]}


def loaded(players):
    """The same agents, one instance of each, which act for one hunter or prey at a time."""
    made = {side: [create_policy(resolve(name).spec, side) for name in names] for side, names in players.items()}
    for one in (one for side in made.values() for one in side):
        one.reset(0)
    return made


def seen_by(config, agent, observation, mask, control):
    """The view of one agent."""
    if agent >= config.hunters:
        return PreyLimits.of(config).view(observation.tolist(), ())
    limits = Limits.of(config.replace(control=control))
    return View(observation.tolist(), mask.tolist() if control == "target" else [], limits)


def drawn(batch, source, count):
    """Players of some arenas, among them learners."""
    numbers = np.full((count, batch.seated.shape[1]), LEARNER)
    for players in batch.players.values():
        shape = numbers[:, players.agents].shape
        numbers[:, players.agents] = source.integers(LEARNER, len(players.pool), shape)
    return numbers


@pytest.mark.parametrize(
    ("name", "players"),
    [
        ("standard", {"hunter": ["nearest", "intercept", "first"]}),
        ("partners", {"hunter": ["together", "nearest"]}),
        ("tag", TWO_SIDES),
        ("herd", TWO_SIDES),
        ("standard", {"hunter": []}),
    ],
)
def test_learners_and_agents_of_any_control_play_what_a_vector_arena_plays(name, players):
    """The agents' actions are computed one by one; the players change from episode to episode."""
    config = scenario(name, control="velocity", **SHORT)
    batch, plain = PlayerBatch.of(config, 4, players), VectorArena(config, 4, any_control=True)
    policies, source = loaded(players), np.random.default_rng(2)
    batch.reset(5)
    observations, infos = plain.reset(5)
    over, endings = np.ones(4, np.bool_), 0
    for _ in range(60):
        if over.any():
            batch.seat(np.flatnonzero(over), drawn(batch, source, over.sum()))
            controls = {LEARNER: "velocity", **dict(enumerate(map(control_of, policies["hunter"])))}
            plain.set_controls(
                [[CONTROLS[controls[number]] for number in row[: config.hunters]] for row in batch.seated]
            )
        commands = source.uniform(-1, 1, (*batch.seated.shape, 2)).astype(np.float32)
        expected, choices = commands.copy(), np.zeros((4, config.hunters), np.int64)
        for (arena, agent), number in np.ndenumerate(batch.seated):
            if number == LEARNER:
                continue
            side = "hunter" if agent < config.hunters else "prey"
            policy = policies[side][number]
            control = "velocity" if side == "prey" else control_of(policy)
            size = plain.observation_space(agent).shape[0]
            mask = infos["action_mask"][arena, agent] if side == "hunter" else None
            action = policy.act(seen_by(config, agent, observations[arena, agent, :size], mask, control))
            if control == "target":
                choices[arena, agent] = action
            else:
                expected[arena, agent] = action
        rewards, *ends, _ = batch.step(commands)
        over = np.logical_or(*ends)
        observations, wanted, terminations, truncations, infos = plain.step(choices, expected)
        endings += over.sum()
        np.testing.assert_array_equal(rewards, wanted)
        np.testing.assert_array_equal(over, terminations | truncations)
        np.testing.assert_array_equal(batch.observations, observations)
        assert [batch.arena.digest(arena) for arena in range(4)] == [plain.digest(arena) for arena in range(4)]
    assert endings == 8


@pytest.mark.parametrize("seed", [None, 3])
def test_the_first_reset_begins_the_agents_also_without_a_seed(seed):
    """They may need what `reset` makes; later resets without a seed leave them as they are."""

    class Counts:
        resets = 0

        def reset(self, _):
            Counts.resets += 1

        def act_batch(self, view):
            return np.zeros(len(view.observations), np.int64)

    batch = PlayerBatch.of(scenario("duel", **SHORT), 2, {"hunter": [Counts]})
    for _ in range(2):
        batch.reset(seed)
        seed = None
    assert Counts.resets == 1


@pytest.mark.parametrize("number", [-2, 1])
def test_a_number_that_no_player_has_is_refused_and_seats_nobody(number):
    batch = PlayerBatch.of(scenario("duel", **SHORT), 2, {"hunter": ["nearest"]})
    batch.seat(np.arange(2), np.zeros((2, 2), np.int64))
    with pytest.raises(ConfigError, match=rf"numbers from -1 \(LEARNER\) to 0, got {number}$"):
        batch.seat(np.arange(2), np.full((2, 2), number))
    assert batch.seated.tolist() == [[0, 0], [0, 0]]


def test_a_step_before_the_first_reset_is_refused():
    batch = PlayerBatch.of(scenario("duel", **SHORT), 2, {"hunter": ["nearest"]})
    with pytest.raises(EpisodeError, match=r"^step\(\) was called before the first reset; call reset\(\) first$"):
        batch.step(np.zeros((2, 2, 2), np.float32))


def test_an_action_of_a_learner_that_is_not_legal_is_refused_before_the_players_act():
    batch = PlayerBatch.of(scenario("duel", control="velocity", **SHORT), 2, {"hunter": [Turning]})
    batch.reset(1)
    batch.seat(np.arange(2), np.array([[0, LEARNER], [0, LEARNER]]))
    commands = np.zeros((2, 2, 2), np.float32)
    commands[1, 1] = np.nan
    with pytest.raises(ActionError, match="in arena 1 for hunter_1"):
        batch.step(commands)
    assert (commands[:, 0] == 0).all()


def test_after_a_player_that_raised_at_its_start_all_arenas_must_be_reset():
    """Other agents of the arenas may have no player."""

    class Late:
        def reset(self, _):
            raise ValueError("late")

        def act(self, view):
            raise NotImplementedError

    batch = PlayerBatch.of(scenario("duel", control="velocity", **SHORT), 2, {"hunter": ["nearest", Late]})
    batch.reset(1)
    with pytest.raises(AgentError, match="late for hunter_0 in arena 0"):
        batch.seat(np.arange(2), np.array([[1, 0], [0, 0]]))
    with pytest.raises(EpisodeError, match="call reset"):
        batch.step(np.zeros((2, 2, 2), np.float32))
    batch.reset()
    batch.step(np.zeros((2, 2, 2), np.float32))
    assert batch.seated.tolist() == [[LEARNER, LEARNER]] * 2
    batch.seat(np.arange(2), np.zeros((2, 2), np.int64))
    batch.step(np.zeros((2, 2, 2), np.float32))


def test_a_side_is_seen_by_those_who_play_it():
    """Views of hunters and of prey have the columns, masks and limits of their side."""
    config = scenario("tag", **SHORT)
    batch = PlayerBatch.of(config, 3, TWO_SIDES)
    batch.reset(1)
    batch.seat(np.arange(3), np.array([[0, LEARNER, 1, LEARNER], [1, 1, 1, 0], [LEARNER, 0, 0, LEARNER]]))
    arenas, agents = batch.rows("hunter")
    assert list(zip(arenas.tolist(), agents.tolist(), strict=True)) == [(0, 1), (2, 0)]
    view = batch.view("hunter", (arenas, agents))
    assert view.observations.tolist() == batch.observations[arenas, agents].tolist()
    assert view.limits == Limits.of(config)
    arenas, agents = batch.rows("prey")
    assert list(zip(arenas.tolist(), agents.tolist(), strict=True)) == [(0, 3), (2, 3)]
    prey = batch.view("prey", (arenas, agents))
    assert prey.observations.shape == (2, len(prey_columns(config)))
    assert prey.limits == PreyLimits.of(config)


def test_a_player_that_is_added_later_can_be_seated():
    batch = PlayerBatch.of(scenario("duel", control="velocity", **SHORT), 2, {"hunter": ["nearest"]})
    batch.reset(3)
    assert batch.players["hunter"].add(Turning(0.5)) == 1
    batch.seat(np.arange(2), np.array([[1, 1], [0, LEARNER]]))
    commands = np.zeros((2, 2, 2), np.float32)
    batch.step(commands)
    assert commands.tolist() == [[[1.0, 0.5]] * 2, [[0.0, 0.0]] * 2]


class Turning:
    """An agent that drives in circles."""

    control = "velocity"

    def __init__(self, turn=1.0):
        self.turn = turn

    def reset(self, seed):
        self.seed = seed

    def act_batch(self, view):
        return np.full((len(view.observations), 2), (1.0, self.turn))


@pytest.mark.parametrize(
    ("name", "players", "error", "message"),
    [
        ("unequal", {"hunter": ["nearest"]}, ConfigError, "hunters must have equal limits, and those of this scenario"),
        ("duel", {"hunter": ["nobody"]}, AgentError, "nobody"),
        ("tag", {"prey": ["nearest"]}, AgentError, "nearest"),
        ("duel", {"hunter": [object()]}, AgentError, "player object: must have the methods reset and act_batch"),
    ],
)
def test_what_cannot_play_is_refused_in_one_line(name, players, error, message):
    with pytest.raises(error, match=message) as caught:
        PlayerBatch.of(scenario(name), 2, players)
    assert "\n" not in str(caught.value)


ENDING = scenario("tag", prey_returns_s=None, reach_m=1.0, max_cycles=80)
"""A match ends when prey is caught, so the arenas end at different times."""


@pytest.mark.parametrize(
    ("config", "names"),
    [
        (ENDING, ["intercept", "nearest", "intercept", "flee"]),
        (scenario("herd", **SHORT), ["nearest", "intercept", "nearest", "patrol", *["corners"] * 4]),
        (scenario("pairs", **SHORT), ["intercept", "nearest", "contested", "patrol"]),
    ],
)
def test_a_match_is_that_of_a_one_arena_env(config, names):
    """The first match of each arena alone counts, with the seeds of a batch."""
    hunters, prey = names[: config.hunters], names[config.hunters :]
    players = {"hunter": [*dict.fromkeys(hunters)], **({"prey": prey[:1]} if prey else {})}
    row = [*map(players["hunter"].index, hunters), *[0] * len(prey)]
    found = play_matches(config, players, np.tile(row, (6, 1)), 4)
    policies, lengths = loaded({"hunter": hunters, "prey": prey}), set()
    env = catch_arena.parallel_env(config, control=tuple(map(control_of, policies["hunter"])))
    everyone = [*policies["hunter"], *policies["prey"]]
    for arena, seed in enumerate(batch_seeds(4, 6).tolist()):
        observations, infos = env.reset(seed=seed)
        for policy in everyone:
            policy.reset(0)
        while env.agents:
            actions = {}
            for place, (name, policy) in enumerate(zip(env.possible_agents, everyone, strict=True)):
                if name in env.agents:
                    control = "velocity" if place >= config.hunters else control_of(policy)
                    mask = infos[name].get("action_mask")
                    actions[name] = policy.act(seen_by(config, place, observations[name], mask, control))
            observations, *_, infos = env.step(actions)
        world = env.world()
        lengths.add(world.step)
        assert found["score"][arena].tolist() == [one.score for one in world.hunters]
        if prey:
            assert found["times_caught"][arena].tolist() == [one.times_caught for one in world.prey]
        best = max(found["team_score"][arena])
        assert ((found["rank"][arena, : config.hunters] == 1) == (found["team_score"][arena] == best)).all()
    assert found["score"].any()
    assert (len(lengths) > 1) == (config is ENDING)


def test_the_same_seed_plays_the_same_matches():
    seated = np.array([[0, 1, 0, 0], [1, 1, 0, 0], [1, 0, 0, 0]])
    config = scenario("tag", **SHORT | {"max_cycles": 100})
    one, again, other = (play_matches(config, TWO_SIDES, seated, seed) for seed in (7, 7, 8))
    assert set(one) == {"score", "team_score", "rank", "times_caught"}
    assert {name: table.shape for name, table in one.items()} == {
        "score": (3, 3), "team_score": (3, 3), "rank": (3, 4), "times_caught": (3, 1),
    }  # fmt: skip
    assert all((again[name] == table).all() for name, table in one.items())
    assert (one["score"] != other["score"]).any()
