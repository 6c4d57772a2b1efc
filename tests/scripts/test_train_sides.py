"""examples/train_sides.py: short runs, what they leave, and what goes wrong."""

import importlib
import json
import sys
from functools import partial

import numpy as np
import pytest
import training_runs
from command_line import run as catch_arena
from training_runs import ROOT, check, refused_here

from catch_arena import scenario
from catch_arena.layout import columns, prey_columns
from catch_arena.training import Mlp
from catch_arena.training.flat import COMMANDS

pytestmark = pytest.mark.torch

train = partial(training_runs.train, module="train_sides")
refused = partial(training_runs.refused, module="train_sides")
SHORT = ("--hidden=8", "--arenas=16", "--seed=3", "--decisions=512", "--evaluate=400", "--matches=2")


@pytest.fixture(scope="module")
def module():
    """examples/train_sides.py."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "examples")
        patch.delitem(sys.modules, "train_ppo", raising=False)
        yield importlib.import_module("train_sides")


def rows_of(out):
    """Evaluations of a run."""
    found = json.loads((out / "curve.json").read_text())
    for row in found["curve"]:
        for figure in {"catches", "wins"} & row.keys():
            mean, low, high = row[figure]
            assert low <= mean <= high
    return found["curve"]


def weights_of(path):
    """Tables of an .npz file."""
    with np.load(path) as file:
        return {name: file[name] for name in file.files}


def test_both_sides_of_tag_learn_and_play_in_a_tournament(tmp_path):
    """More past selves than the pool keeps."""
    out = tmp_path / "run"
    printed = train("--out", out, *SHORT, "--decisions", 1800, "--prey-opponents", "flee,flee", MOST_SELVES=2)
    assert f"{out}: curve.json, and agents hunters.py, prey.py" in printed.splitlines()
    curve = rows_of(out)
    assert [(row["side"], row["against"]) for row in curve[:3]] == [
        ("hunters", "flee"), ("hunters", "flee"), ("prey", "intercept"),
    ]  # fmt: skip
    assert all("wins" not in row for row in curve)
    assert curve[0]["decisions"] == 0
    assert curve[-1]["decisions"] > 0
    assert curve[-1]["catches"][0] > 0, "intercept has caught no prey"
    for side, table in (("hunters", columns), ("prey", prey_columns)):
        decisions = sorted({row["decisions"] for row in curve if row["side"] == side})
        assert decisions[-1] >= 1800 or side == "prey"
        kept = {f"{side}_{number}.{kind}" for number in decisions for kind in ("npz", "py")}
        assert kept == {path.name for path in (out / "snapshots").glob(f"{side}_*")}
        assert Mlp.load(out / f"{side}.npz").inputs == len(table(scenario("tag")))
        check(out / f"{side}.py", "tag")
        first, last = (weights_of(out / "snapshots" / f"{side}_{number}.npz") for number in (0, decisions[-1]))
        assert (first["w_0"] != last["w_0"]).any()
    training_runs.run("scripts/ladder.py", out, "--out", tmp_path / "ladder")
    hunters, prey = sorted((tmp_path / "ladder").glob("*.py"))
    assert f"from catch_arena.agents.ladder.{hunters.stem} import Agent" in prey.read_text()
    check(hunters, "tag")
    agents = [out / "hunters.py", out / "prey.py", out / "snapshots" / "prey_0.py", "intercept", "nearest"]
    played = catch_arena(
        "tournament", *agents, "--scenario", "tag", "--rounds", 1, "--set", "time_limit_s=3", "--trusted",
        "--out", tmp_path / "results",
    )  # fmt: skip
    assert played.exit_code == 0, played.output
    standings = json.loads((tmp_path / "results" / "standings.json").read_text())
    assert "forfeit" not in played.output
    assert {"hunters", "prey", "prey_0"} <= {row["agent"] for row in standings["standings"]}


@pytest.mark.parametrize(
    ("name", "options", "sides"),
    [
        ("standard", "--learn seat --opponents nearest,intercept", {"seat": "Mlp.save"}),
        ("partners", "--learn team --opponents together", {"team": "Mlp.save"}),
        ("pack", "--learn hunters,prey --network pointer", {"hunters": "PointerNetwork.save", "prey": "Mlp.save"}),
        *(
            pytest.param(*values, marks=pytest.mark.nightly)
            for values in (
                ("standard", "--learn seat --network pointer --self-play 0 --hold 3", {"seat": "PointerNetwork.save"}),
                ("tag", "--learn seat", {"seat": "Mlp.save"}),
                ("tag", "--learn prey --opponents nearest,random --prey-opponents corners", {"prey": "Mlp.save"}),
                ("herd", "--learn seat,prey --self-play 1 --hold 2", {"seat": "Mlp.save", "prey": "Mlp.save"}),
            )
        ),
    ],
)
def test_any_side_of_a_scenario_learns(tmp_path, name, options, sides):
    """A seat, a whole team, all hunters, and prey; with both networks."""
    train("--out", tmp_path, "--scenario", name, *SHORT, *options.split())
    curve = rows_of(tmp_path)
    assert {row["side"] for row in curve} == sides.keys()
    for row in curve:
        assert ("wins" in row) == (row["side"] in ("seat", "team"))
    if "nearest,intercept" in options:
        assert [row["against"] for row in curve[:2]] == ["nearest", "intercept"]
    for side, kind in sides.items():
        assert ("w_0" in weights_of(tmp_path / f"{side}.npz")) == (kind == "Mlp.save")
        check(tmp_path / f"{side}.py", name)


def test_the_same_seed_learns_the_same(tmp_path):
    for name, seed in (("one", 5), ("again", 5), ("other", 6)):
        train("--out", tmp_path / name, *SHORT, "--seed", seed)
    one, again, other = (tmp_path / name for name in ("one", "again", "other"))
    for side in ("hunters", "prey"):
        mine, same, another = (weights_of(out / f"{side}.npz") for out in (one, again, other))
        for name, table in mine.items():
            np.testing.assert_array_equal(table, same[name])
        assert (mine["w_0"] != another["w_0"]).any()
    assert [row | {"seconds": 0} for row in rows_of(one)] == [row | {"seconds": 0} for row in rows_of(again)]


@pytest.mark.nightly
def test_runs_are_measured_against_each_other(tmp_path):
    """Each snapshot plays the last agents of the other run."""
    runs, out = [tmp_path / "one", tmp_path / "two"], tmp_path / "others"
    for seed, run in enumerate(runs):
        train("--out", run, *SHORT, "--seed", seed)
    training_runs.run("examples/measure_others.py", *runs, "--matches", 4, "--out", out)
    for run in runs:
        measured = {(row["side"], row["decisions"], row["against"]) for row in rows_of(out / run.name)}
        opponents = {"hunters": "prey of other runs", "prey": "hunters of other runs"}
        assert measured == {(row["side"], row["decisions"], opponents[row["side"]]) for row in rows_of(run)}
    printed = training_runs.run("examples/training_curves.py", *(out / run.name for run in runs))
    assert "catches of hunters of other runs against prey in tag:" in printed
    train("--out", tmp_path / "prey", *SHORT, "--learn", "prey")
    for words, error in (
        (runs[:1], "give two or more runs with equal --scenario and --learn"),
        ([runs[0], tmp_path / "prey"], "give two or more runs with equal --scenario and --learn"),
        ([runs[0], out], f"No such file or directory: '{out / 'curve.json'}'"),
        ([*runs, "--matches", 1], "--matches must be at least 2, got 1"),
    ):
        refusal = training_runs.run("examples/measure_others.py", *words, "--out", out, fails=True)
        assert error in refusal.splitlines()[-1]


def test_the_network_decides_the_same_in_torch_and_in_numpy(module):
    """The standardisation is part of the first layer."""
    import torch

    torch.manual_seed(1)
    network = module.Flat(6, 8, "tag")
    seen = torch.randn(500, 6) * torch.tensor([1.0, 30.0, 0.01, 1.0, 2.0, 0.0]) + torch.tensor([0.0, 7, 1, -3, 0, 4])
    network.standardise(seen)
    standard = (seen - network.middle) / network.scale
    np.testing.assert_allclose(standard.mean(0), np.zeros(6), atol=1e-3)
    np.testing.assert_allclose(standard.std(0), [1, 1, 1, 1, 1, 0], atol=1e-3)
    with torch.no_grad():
        network.actor[-1].weight.normal_(0, 1)
        log_p, _, _ = network(seen)
    outputs = network.agent().network(seen.numpy()).astype(np.float64)
    np.testing.assert_allclose(log_p, outputs - np.log(np.exp(outputs).sum(axis=1, keepdims=True)), atol=1e-4)
    assert outputs.shape == (500, len(COMMANDS))


def test_the_mean_of_matches_has_an_interval(module):
    assert module.interval(np.array([1.0, 2.0, 3.0, 4.0])) == [2.5, 1.235, 3.765]  # 1.96 * 1.291 / 2


def test_ctrl_c_is_one_line_and_keeps_the_last_evaluation(tmp_path):
    out = tmp_path / "run"
    process = training_runs.begun("--out", out, *SHORT, "--decisions", 10**9, module="train_sides", SNAPSHOT=10**9)
    for line in process.stdout:
        if "decisions/s" in line:
            break
    output = training_runs.interrupted(process)
    assert output[-1] == f"catch-arena: interrupted: {out} has the agents of the last evaluation"
    assert not [line for line in output if "Traceback" in line]
    assert rows_of(out)
    check(out / "hunters.py", "tag")
    again = refused("--out", out, *SHORT)
    assert again == f"train_sides: --out must be a new folder: {out} has a run already"


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ("--learn team", "--learn must name sides of tag (seat, hunters, prey), got 'team'"),
        ("--scenario standard --learn prey", "--learn must name sides of standard (seat), got 'prey'"),
        ("--scenario standard", "--learn must name sides of standard (seat), got 'hunters'"),
        (
            "--scenario partners --learn seat,team",
            "--learn must name one side of hunters, prey, or both; got seat,team",
        ),
        ("--learn prey,prey", "--learn must name one side of hunters, prey, or both; got prey,prey"),
        ("--learn runner", "got 'runner'"),
        ("--scenario moon", "train_sides: unknown scenario 'moon'"),
        ("--scenario unequal --learn seat", "train_sides: hunters must have equal limits"),
        ("--opponents nobody", "nobody"),
        ("--opponents nearest,", "an agent must be a name, a file, a folder or a command"),
        ("--self-play 2", "--self-play must be from 0 to 1, got 2.0"),
        ("--self-play nan", "--self-play must be from 0 to 1, got nan"),
        ("--entropy nan", "--entropy must be from 0 to 1, got nan"),
        ("--progress nan", "rewards.progress must be at least -1e+06"),
        ("--decisions 0", "--decisions must be at least 1, got 0"),
        ("--hold 0", "--hold must be at least 1, got 0"),
        ("--arenas 8", "--arenas must be at least 16, got 8"),
        ("--matches 1", "--matches must be at least 2, got 1"),
        ("--seed -1", "--seed must be at least 0, got -1"),
        ("--network deep", "argument --network: invalid choice: 'deep'"),
    ],
)
def test_bad_options_are_one_line(module, tmp_path, arguments, error, monkeypatch, capsys):
    given = ["--out", tmp_path / "run", *SHORT, *arguments.split()]
    assert error in refused_here(module, given, monkeypatch, capsys)
    assert not (tmp_path / "run").exists()
