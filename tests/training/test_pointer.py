"""Pointer networks are saved, loaded and played, and damaged files are refused."""

import re
import zipfile
from pathlib import Path

import numpy as np
import pytest

import catch_arena
from catch_arena import agents
from catch_arena.batch_policy import BatchView
from catch_arena.errors import ConfigError
from catch_arena.layout import prey_observation_size
from catch_arena.policy import Limits, View
from catch_arena.training.networks import Mlp
from catch_arena.training.pointer import CONTROL_OF, PointerAgent, PointerNetwork, weight_shapes


def network(head="destination", hidden=8, prior=1.5, seed=3):
    source = np.random.default_rng(seed)
    weights = {name: source.normal(0, 0.4, shape) for name, shape in weight_shapes(head, hidden).items()}
    return PointerNetwork(head, weights | {"prior": np.float32(prior)})


@pytest.mark.parametrize("head", list(CONTROL_OF))
@pytest.mark.parametrize("scenario", ["standard", "crowd", "evasive", "fog", "pairs", "duel"])
def test_an_agent_acts_alike_alone_and_for_many_and_always_legally(head, scenario):
    agent = PointerAgent(network(head))
    config = catch_arena.scenario(scenario, control=agent.control, max_cycles=30)
    arena, limits = catch_arena.VectorArena(config, 4), Limits.of(config)
    observations, infos = arena.reset(seed=2)
    for _ in range(6):
        masks = infos.get("action_mask", np.ones((*observations.shape[:2], 0), np.int8))
        actions = np.stack(
            [
                agent.act_batch(BatchView(observations[:, seat], masks[:, seat], limits))
                for seat in range(config.hunters)
            ],
            1,
        )
        for seat in range(config.hunters):
            alone = agent.act(View(observations[0, seat].tolist(), masks[0, seat].tolist(), limits))
            np.testing.assert_allclose(actions[0, seat], alone, atol=1e-4)
        observations, _, _, _, infos = arena.step(**{"choices" if agent.control == "target" else "commands": actions})


def test_a_network_is_written_and_read(tmp_path):
    made = network("velocity")
    made.save(tmp_path / "made.npz")
    read = PointerNetwork.load(tmp_path / "made.npz")
    assert read.head == "velocity"
    for name, table in made.weights.items():
        assert (read.weights[name] == table).all()


def test_a_file_that_cannot_be_played_says_why(tmp_path):
    """In one line that names the file."""
    good = tmp_path / "good.npz"
    network().save(good)
    with np.load(good) as file:
        tables = {name: file[name] for name in file.files}

    def error_of(name, **changed):
        path = tmp_path / f"{name}.npz"
        kept = {key: value for key, value in (tables | changed).items() if value is not None}
        np.savez(path, **kept)
        with pytest.raises(ConfigError, match=re.escape(str(path))) as error:
            PointerNetwork.load(path)
        assert "\n" not in str(error.value)
        return str(error.value)

    assert "ruleset must be catch_arena_v1, got catch_arena_v9; train the network again" in error_of(
        "rules", ruleset="catch_arena_v9"
    )
    assert "features must be 1, got 0; train the network again" in error_of("features", features=0)
    assert "KeyError: 'ruleset'" in error_of("none", ruleset=None)
    assert "weights logit must have the shape (8,), got nothing" in error_of("missing", logit=None)
    assert "weights encode must have the shape (45, 8), got (71, 8)" in error_of("width", encode=np.zeros((71, 8)))
    assert "weights mix_bias must be finite numbers, got nan" in error_of("nan", mix_bias=np.full(8, np.nan))
    assert "weights mix_bias must be finite numbers, got inf" in error_of("inf", mix_bias=np.array([0.0, np.inf] * 4))
    assert "head must be one of" in error_of("head", head="tail")

    whole = good.read_bytes()
    for cut in (0, 10, len(whole) // 2, len(whole) - 5):
        (tmp_path / "cut.npz").write_bytes(whole[:cut])
        with pytest.raises(ConfigError, match=r"cut\.npz: cannot load a file from PointerNetwork\.save"):
            PointerNetwork.load(tmp_path / "cut.npz")
    with pytest.raises(ConfigError, match=r"gone\.npz"):
        PointerNetwork.load(tmp_path / "gone.npz")


def test_nothing_in_a_file_of_weights_is_run(tmp_path):
    """An .npz may hold pickled objects: these are refused."""

    class Evil:
        def __reduce__(self):
            return (print, ("run",))

    np.savez(tmp_path / "evil.npz", head=np.array([Evil()], dtype=object))
    with pytest.raises(ConfigError, match=r"evil\.npz"):
        PointerNetwork.load(tmp_path / "evil.npz")


def test_the_weights_that_ship_are_small_finite_and_no_pickles():
    files = sorted(Path(agents.__path__[0]).glob("*.npz"))
    assert len(files) >= 3
    for file in files:
        assert file.stat().st_size < 1_000_000
        assert zipfile.ZipFile(file).testzip() is None
        if file.stem.endswith("_prey"):  # beside the hunters' own
            assert file.with_name(f"{file.stem.removesuffix('_prey')}.py").is_file()
            assert Mlp.load(file).inputs == prey_observation_size(catch_arena.scenario("tag"))
            continue
        loaded = PointerNetwork.load(file)
        assert file.with_suffix(".py").is_file()
        assert sum(table.size for table in loaded.weights.values()) > 10_000
