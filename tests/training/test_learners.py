"""`LearnerBatch` and the Gymnasium env give learners rows of their own, and can be saved and restored."""

import copy
import io
import pickle
import re
import sys
import threading

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers import vector as wrappers

import catch_arena
from catch_arena import training
from catch_arena.errors import ActionError, AgentError, ConfigError, EpisodeError
from catch_arena.training import GymnasiumVectorEnv, LearnerBatch, Mlp


@pytest.mark.parametrize("control", ["target", "velocity", "full"])
@pytest.mark.parametrize("opponents", [None, "patrol"])
def test_rows_are_the_callers_own(control, opponents):
    """stable-baselines3 stores an observation after the next step; it must still be the one that was seen."""
    batch = LearnerBatch("standard", 3, opponents=opponents, control=control, max_cycles=4)
    rows = batch.num_rows
    actions = {
        "target": np.ones(rows, int),
        "velocity": np.full((rows, 2), 0.5),
        "full": {"cmd_vel": np.full((rows, 2), 0.5), "catch": np.zeros(rows, int)},
    }[control]
    kept = [batch.reset(seed=1)[0]]
    copies = [kept[0].copy()]
    for _ in range(6):
        result = batch.step(actions)
        for array in (*result[:5], result.final_observations, result.final_masks):
            assert not np.shares_memory(array, batch.arena._engine._memory)
        kept.append(result.observations)
        copies.append(result.observations.copy())
        assert result.masks.shape == (rows, 0 if control == "velocity" else 9)
        assert batch.observation_space.contains(result.observations[0])
        assert len(result.ended) == len(result.final_observations) == len(result.final_masks)
    assert rows == (12 if opponents is None else 3)
    assert all((one == other).all() for one, other in zip(kept, copies, strict=True))


def test_normalised_columns_lie_between_minus_one_and_one_and_what_is_absent_stays_zero():
    """Divided by the largest magnitude in the public table of columns."""
    plain, normal = (LearnerBatch("duel", 8, normalise=normalise, max_cycles=30) for normalise in (False, True))
    seen, scaled = plain.reset(seed=2)[0], normal.reset(seed=2)[0]
    largest = np.array([max(abs(column.low), abs(column.high)) for column in catch_arena.columns(plain.config)])
    for _ in range(31):
        assert np.allclose(scaled, seen / largest, atol=1e-6)
        assert ((scaled == 0) == (seen == 0)).all()
        assert normal.observation_space.contains(scaled[0])
        one, other = plain.step(np.ones(16, int)), normal.step(np.ones(16, int))
        seen, scaled = one.observations, other.observations
    assert len(one.ended) + len(other.ended) == 0
    assert normal.observation_space.low.min() >= -1
    assert normal.observation_space.high.max() == 1


def test_arenas_that_do_not_reset_by_themselves_give_their_last_observations():
    """TorchRL resets them one by one, by a mask; the others go on."""
    batch = LearnerBatch("duel", 3, opponents="nearest", auto_reset=False, max_cycles=3)
    batch.reset(seed=1)
    for _ in range(3):
        result = batch.step(np.zeros(3, int))
    assert result.truncations.all()
    assert (result.final_observations == result.observations).all()
    seats = batch.seats
    assert (batch.reset(arenas=[])[0] == result.observations).all()
    observations, _ = batch.reset(arenas=np.array([False, True, False]))
    assert (observations[[0, 2]] == result.observations[[0, 2]]).all()
    assert batch.arena.world(1).step == 0
    assert (batch.seats != seats).any(axis=1).tolist() == [False, True, False]


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"learners": 2, "opponents": "nearest"}, "learners must be a whole number from 1 to 1, got 2"),
        ({"learners": 0}, "learners must be a whole number from 1 to 2"),
        ({"hunters": 1, "opponents": "nearest"}, "hunters must be at least 2 if there are opponents, got 1"),
        ({"prey_agent": "flee"}, "prey_agent must be None in a scenario without prey, got flee"),
        ({"normalise": 1}, "normalise must be true or false, got 1"),
        ({"control": ("target", "full")}, "control must be one word, for all learners"),
        ({"num_envs": 10**8}, "num_envs must fit into this machine's memory, got 100000000"),
        ({"num_envs": 0}, "num_envs must be a whole number from 1"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(settings, message):
    """A hundred million duels take a terabyte."""
    with pytest.raises(ConfigError, match=message) as caught:
        LearnerBatch("duel", **{"num_envs": 2, **settings})
    assert "\n" not in str(caught.value)


def test_bad_actions_of_learners_are_refused_and_nothing_moves():
    """Shape, type and value, with and without opponents; and a step before the first reset."""
    for opponents, rows in ((None, 6), ("nearest", 3)):
        batch = LearnerBatch("duel", 3, opponents=opponents)
        with pytest.raises(EpisodeError, match="was called before the first reset"):
            batch.step(np.zeros(rows, int))
        batch.reset(seed=1)
        before = batch.arena.digest(2)
        named = {"catch": np.zeros(rows, int)}
        for bad in (np.zeros(rows + 1, int), np.zeros(rows), np.zeros((rows, 2), int), np.full(rows, 9), named):
            with pytest.raises(ActionError):
                batch.step(bad)
        assert batch.arena.digest(2) == before
    batch = LearnerBatch("duel", 3, control="full")
    batch.reset(seed=1)
    for bad in (np.zeros((6, 2)), {"cmd_vel": np.zeros((6, 2)), "rank": np.zeros(6, int)}):
        with pytest.raises(ActionError, match="actions must be a mapping with cmd_vel and catch"):
            batch.step(bad)


class Counting:
    """Counts its calls, and plays by the count."""

    def __init__(self, control):
        self.control, self.calls = control, 0

    def reset(self, seed):
        """Nothing to forget."""

    def act_batch(self, view):
        self.calls += 1
        ranks, commands = np.full(len(view.observations), self.calls % 2), np.zeros((len(view.observations), 2))
        return {"target": ranks, "velocity": commands, "full": {"cmd_vel": commands, "catch": ranks}}[self.control]


@pytest.mark.parametrize(
    ("control", "bad"),
    [
        ("target", [0, 9, 0]),
        ("target", [0.0, 1.0, 0.0]),
        ("target", [0, 0]),
        ("velocity", [[0, 0], [float("nan"), 0], [0, 0]]),
        ("velocity", [0, 0, 0]),
        ("full", {"cmd_vel": [[0, 0]] * 3, "catch": [0, 0, 9]}),
        ("full", [0, 0, 0]),
    ],
)
@pytest.mark.parametrize("other", ["target", "velocity", "full"])
def test_no_opponent_acts_in_a_step_that_is_refused(control, bad, other):
    """One that remembers would have acted twice; and what was refused is forgotten when seats change."""
    opponent = Counting(other)
    batch = LearnerBatch("duel", 3, opponents=[opponent], control=control)
    batch.reset(seed=1)
    before = batch.arena.digest(1)
    for _ in range(2):
        with pytest.raises(ActionError) as caught:
            batch.step(bad)
        assert "\n" not in str(caught.value)
    assert (opponent.calls, batch.arena.digest(1)) == (0, before)
    batch.reset()
    good = np.zeros(3, int), np.zeros((3, 2))
    batch.step({"target": good[0], "velocity": good[1], "full": {"catch": good[0], "cmd_vel": good[1]}}[control])
    assert opponent.calls == 1


def drawn_action(batch, rng):
    """Any legal one of each learner."""
    return rng.integers(0, batch.config.targets_seen + 1, batch.num_rows)


def played(batch, seed, steps=50):
    """All that so many steps gave, and who sat where."""
    rng, found = np.random.default_rng(seed), []
    for _ in range(steps):
        step = batch.step(drawn_action(batch, rng))
        found.append([array.tobytes() for array in step[:-1]])
        found.append({name: table.tobytes() for name, table in step.figures.items()})
        found.append(batch.seats.tolist())
        if batch.opponents is not None:
            found.append((batch.opponents.seated.tolist(), batch.opponents.names))
    return found


class Wandering:
    """Keeps a count and a generator of its own, and draws from it for all hunters at once."""

    def reset(self, seed):
        self.rng, self.steps = np.random.default_rng(seed), 0

    def act_batch(self, view):
        self.steps += 1
        ranks = self.rng.integers(0, 9, len(view.observations))
        return np.where(self.steps % 3, ranks, 0)


POOLS = [None, "nearest", ["random", "patrol"], [Wandering, "random", "search"], {"random": 3, "idle": 1}]
GAMES = [("standard", pool, None) for pool in POOLS]
GAMES += [("herd", None, "random"), ("herd", ["random", "patrol"], "corners")]
TAKEN_ALONG = [lambda saved: saved, copy.deepcopy, lambda saved: pickle.loads(pickle.dumps(saved))]  # noqa: S301


@pytest.mark.rule("R10.2")
@pytest.mark.parametrize("carry", TAKEN_ALONG, ids=["as it is", "copied", "pickled"])
@pytest.mark.parametrize(("scenario", "pool", "prey"), GAMES, ids=str)
def test_r10_2_a_batch_of_learners_goes_on_from_any_point(scenario, pool, prey, carry):
    """Restored, restored elsewhere, cloned, copied and pickled: through the ends of episodes, with opponents and prey
    that remember, and with a pool that has grown meanwhile.
    """
    arguments = {"opponents": pool, "learners": 4 if pool is None else 2, "normalise": True, "max_cycles": 12}
    arguments["prey_agent"] = prey
    batch = LearnerBatch(scenario, 3, **arguments)
    batch.reset(seed=4)
    played(batch, 1, 7)
    saved = carry(batch.save())
    twins = [batch.clone(), carry(batch)]
    expected = played(batch, 2)
    if pool is not None:
        batch.opponents.add("tour")
        batch.opponents.weigh([*np.ones(len(batch.opponents.names) - 1), 9])
        played(batch, 3, 14)
    other = LearnerBatch(scenario, 3, **arguments)
    for again in (batch, other):
        for _ in range(2):
            observations, masks = again.restore(saved)
            assert observations.shape == (batch.num_rows, len(batch.columns))
            assert masks.shape == (batch.num_rows, 9)
            assert played(again, 2) == expected
    if carry is not TAKEN_ALONG[0]:
        assert played(twins[1], 2) == expected
    assert played(twins[0], 2) == expected


class Locked(Counting):
    """Holds what cannot be copied."""

    def __init__(self):
        super().__init__("target")
        self.lock = threading.Lock()


class LockedAlone(Locked):
    """Agent for one hunter, which is copied for each hunter."""

    act_batch = None

    def act(self, _view):
        """Hold."""
        return 0


def test_an_opponent_that_cannot_be_copied_is_named():
    """Saving copies it, and so does giving each hunter an instance."""
    batch = LearnerBatch("duel", 2, opponents=["nearest", Locked])
    batch.reset(seed=1)
    for keep in (batch.save, batch.clone):
        with pytest.raises(
            AgentError, match=r"opponent Locked: copying the agent raised TypeError: cannot pickle '_thread"
        ):
            keep()
    with pytest.raises(AgentError, match="opponent LockedAlone: copying the agent raised TypeError"):
        LearnerBatch("duel", 2, opponents=LockedAlone).reset(seed=1)


def test_what_a_batch_cannot_go_on_from_is_refused():
    batch = LearnerBatch("standard", 2, opponents="random", learners=2)
    with pytest.raises(EpisodeError, match=r"save\(\) was called before the first reset"):
        batch.save()
    batch.reset(seed=1)
    before = played(batch.clone(), 1)
    for message, num_envs, arguments in (
        ("saved must come from a batch with learners=2, got 1", 2, {"opponents": "random"}),
        ("saved must come from a batch with learners=2, got 4", 2, {}),
        ("must be that of 2 arenas here, got that of 3 arenas", 3, {"opponents": "random", "learners": 2}),
        ("must come from an arena with an equal config", 2, {"opponents": "random", "learners": 2, "max_cycles": 9}),
    ):
        other = LearnerBatch("standard", num_envs, **arguments)
        other.reset(seed=1)
        with pytest.raises(ConfigError, match=message):
            batch.restore(other.save())
    with pytest.raises(ConfigError, match="saved must be a SavedLearners from save"):
        batch.restore("state")
    assert played(batch, 1) == before


def test_gymnasiums_vector_wrappers_fit():
    """Statistics, rewards and lists of infos, over ended episodes."""
    env = GymnasiumVectorEnv("duel", 3, opponents=["nearest", "patrol"], max_cycles=5)
    assert isinstance(env, gymnasium.vector.VectorEnv)
    assert env.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    env = wrappers.RecordEpisodeStatistics(env)
    env = wrappers.NormalizeReward(env)
    env = wrappers.TransformReward(env, lambda reward: 2 * reward)
    env = wrappers.DictInfoToList(env)
    observations, infos = env.reset(seed=3)
    assert observations.shape == env.observation_space.shape == (3, 71 - 14)
    assert len(infos) == 3
    for step in range(12):
        observations, rewards, _, truncations, infos = env.step(env.action_space.sample())
        assert rewards.shape == (3,)
        assert truncations.all() == (step % 5 == 4)
        if truncations.all():
            assert infos[2]["episode"]["l"] == (5 if step == 4 else infos[2]["episode"]["l"])  # Gymnasium 1.3 then errs
            assert infos[1]["final_info"]["length"] == 5
            assert infos[1]["final_obs"].shape == (57,)
            assert infos[0]["final_info"]["action_mask"][0]
        else:
            assert "final_obs" not in infos[0]
    env.close()


def test_gymnasiums_wrappers_of_observations_fit_where_ended_arenas_wait():
    """They take no env that resets in the same step; arenas are reset by a mask of their rows."""
    env = GymnasiumVectorEnv("standard", 3, opponents="nearest", learners=2, auto_reset=False, max_cycles=5)
    assert env.metadata["autoreset_mode"] is AutoresetMode.DISABLED
    env = wrappers.RescaleObservation(env, -1, 1)
    env.reset(seed=3)
    for _ in range(5):
        *_, truncations, infos = env.step(env.action_space.sample())
    assert truncations.all()
    assert "final_obs" not in infos
    env.reset(options={"reset_mask": np.array([True, True, False, False, False, False])})
    batch = env.unwrapped.batch
    assert [batch.arena.world(row).step for row in range(3)] == [0, 5, 5]
    with pytest.raises(ConfigError, match="reset_mask must be equal for all learners of an arena"):
        env.reset(options={"reset_mask": np.array([True, False, False, False, False, False])})
    with pytest.raises(ConfigError, match=r"reset_mask must be 6 booleans, got bool of the shape \(2,\)"):
        env.reset(options={"reset_mask": np.array([True, False])})


def test_seeds_of_a_gymnasium_env_may_be_a_list_or_a_tuple():
    """Gymnasium's own envs take both, with None among them; the first counts."""
    env = GymnasiumVectorEnv("duel", 3, opponents="nearest")
    expected = env.reset(seed=7)[0]
    for seed in ([7, 8, None], (7, 7, 7)):
        assert (env.reset(seed=seed)[0] == expected).all()
    assert (env.reset(seed=[None, 7, 7])[0] != expected).any()


@pytest.mark.parametrize(("name", "library"), [("SB3VecEnv", "stable_baselines3"), ("TorchRLEnv", "torchrl")])
def test_a_library_that_is_missing_is_named_in_one_line(name, library, monkeypatch):
    """With the extra that brings it."""
    monkeypatch.setitem(sys.modules, library, None)
    monkeypatch.delitem(sys.modules, f"catch_arena.training.{training._HOMES[name]}", raising=False)
    monkeypatch.delitem(training.__dict__, name, raising=False)
    with pytest.raises(ConfigError, match=rf"{name} needs \w+, which is not installed: pip install '\.\["):
        getattr(training, name)


def torch_like(kind, weight=None, bias=None, children=()):
    """A module as torch's, without torch."""

    class Tensor:
        def __init__(self, table):
            self.table = table

        def detach(self):
            return self

        cpu = detach

        def numpy(self):
            return self.table

    module = type(kind, (), {"children": lambda _: iter(children)})()
    if weight is not None:
        module.weight, module.bias = Tensor(weight), Tensor(bias)
    return module


@pytest.mark.parametrize("activation", ["Tanh", "ReLU"])
def test_a_network_goes_to_numpy_and_to_a_file(activation, tmp_path):
    """Linear layers, written out; what was learned from normalised observations takes plain ones."""
    source = np.random.default_rng(1)
    (w1, b1), (w2, b2) = ((source.normal(size=(o, i)), source.normal(size=o)) for i, o in ((6, 5), (5, 3)))
    scale = source.uniform(1, 9, 6)
    body = torch_like("Sequential", children=[torch_like("Linear", w1, b1), torch_like(activation)])
    network = Mlp.of_torch(body, torch_like("Linear", w2, b2), scale=scale)
    network.save(tmp_path / "net.npz")
    again = Mlp.load(tmp_path / "net.npz")
    x = source.normal(size=(4, 6))
    hidden = (x / scale) @ w1.T + b1
    hidden = np.tanh(hidden) if activation == "Tanh" else np.maximum(hidden, 0)

    assert np.allclose(network(x), hidden @ w2.T + b2, atol=1e-4)
    assert (again(x) == network(x)).all()
    assert again(x[0]).shape == (3,)
    assert again.inputs == 6


def test_a_network_stays_as_it_is_while_torch_trains_on():
    weights, biases = np.ones((2, 3), np.float32), np.ones(2, np.float32)
    network = Mlp.of_torch(torch_like("Linear", weights, biases))
    weights[:], biases[:] = 2, 2
    assert network(np.ones(3)).tolist() == [4, 4]


def test_a_network_that_cannot_be_is_refused():
    """Other modules, layers that do not fit, observations of another scenario."""
    layer = torch_like("Linear", np.zeros((2, 3)), np.zeros(2))
    with pytest.raises(ConfigError, match="modules must be Linear, Tanh and ReLU, got Conv2d"):
        Mlp.of_torch(layer, torch_like("Conv2d"))
    with pytest.raises(ConfigError, match="modules must all have the same activation, got relu, tanh"):
        Mlp.of_torch(layer, torch_like("Tanh"), torch_like("ReLU"))
    with pytest.raises(ConfigError, match="layers must be weights"):
        Mlp.of_torch(layer, layer)
    with pytest.raises(ConfigError, match="layers must be weights"):
        Mlp([])
    with pytest.raises(ConfigError, match="activation must be one of tanh, relu, got 'gelu'"):
        Mlp([(np.zeros((2, 3)), np.zeros(2))], "gelu")
    with pytest.raises(
        ConfigError, match=re.escape("observations must have 3 columns for this network, got the shape (57,)")
    ):
        Mlp.of_torch(layer)(np.zeros(57))
    with pytest.raises(ConfigError, match="biases of layer 0 must be finite numbers, got inf"):
        Mlp([(np.zeros((2, 3)), np.array([1.0, np.inf]))])


def test_a_file_that_is_no_network_says_so_in_one_line(tmp_path):
    """Damaged anywhere, of something else, of another ruleset, with what is no number."""
    good = tmp_path / "good.npz"
    Mlp([(np.ones((4, 3)), np.zeros(4)), (np.ones((2, 4)), np.zeros(2))]).save(good)
    whole = good.read_bytes()
    with np.load(good) as file:
        tables = {name: file[name] for name in file.files}

    def error_of(content):
        path = tmp_path / "other.npz"
        path.write_bytes(content) if isinstance(content, bytes) else np.savez(path, **content)
        with pytest.raises(ConfigError, match=re.escape(str(path))) as error:
            Mlp.load(path)
        assert "\n" not in str(error.value)
        return str(error.value)

    lone = io.BytesIO()
    np.save(lone, np.zeros(3))
    for content in (b"text", b"", whole[:10], whole[: len(whole) // 2], lone.getvalue()):
        assert "cannot load a file from Mlp.save" in error_of(content)
    assert "ruleset must be catch_arena_v1, got catch_arena_v0; train the network again" in error_of(
        tables | {"ruleset": "catch_arena_v0"}
    )
    assert "KeyError: 'ruleset'" in error_of({name: table for name, table in tables.items() if name != "ruleset"})
    assert "weights of layer 1 must be finite numbers, got nan" in error_of(tables | {"w_1": np.full((2, 4), np.nan)})
    assert "layers must be weights" in error_of(tables | {"w_1": np.zeros((2, 5))})
    assert "cannot load a file from Mlp.save" in error_of(
        {name: table for name, table in tables.items() if name != "w_1"}
    )
    with pytest.raises(ConfigError, match=r"none\.npz: cannot load a file from Mlp\.save"):
        Mlp.load(tmp_path / "none.npz")
