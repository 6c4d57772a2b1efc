"""Frozen learned agents play under their names, and scripts/ladder.py makes them from training runs."""

import json
import re
import runpy
import sys
from pathlib import Path

import command_line
import numpy as np
import pytest

from catch_arena import scenario
from catch_arena.config import RULESET
from catch_arena.errors import AgentError, ConfigError
from catch_arena.layout import columns, prey_columns
from catch_arena.tournament.agent_spec import is_shipped, ladder_names, resolve, shipped_names
from catch_arena.tournament.loading import create_policy
from catch_arena.tournament.players import enter
from catch_arena.training import Mlp
from catch_arena.training.flat import COMMANDS
from catch_arena.training.player_batch import play_matches
from catch_arena.training.pointer import PointerNetwork, weight_shapes

ROOT = Path(__file__).parents[2]
LADDER = runpy.run_path(str(ROOT / "scripts" / "ladder.py"))
copy_run = LADDER["copy_run"]
AGENT = """'A snapshot.'

from pathlib import Path

from catch_arena.agents.nearest import Agent as Agent
from catch_arena.training.{module} import {base}


class {kind}({base}):
    def __init__(self):
        super().__init__(Path(__file__).with_suffix(".npz"){more})
"""
MOST_KB = 1300
"""Size that all weights of the ladder may have together."""


def a_run(folder, learn=("hunters", "prey"), network="flat", ages=(0, 1000, 40_300)):
    """Write a run as examples/train_sides.py does; prey makes half as many decisions."""
    rng = np.random.default_rng(1)
    (folder / "snapshots").mkdir(parents=True)
    settings = {"scenario": "tag", "learn": list(learn), "network": network, "seed": 7}
    (folder / "curve.json").write_text(json.dumps({"settings": settings}))
    for side in learn:
        for age in ages:
            file = folder / "snapshots" / f"{side}_{age // (2 if side == 'prey' else 1)}.npz"
            facts = {"module": "flat", "base": "FlatAgent", "more": ", 'tag'"}
            if network == "pointer" and side != "prey":
                facts = {"module": "pointer", "base": "PointerAgent", "more": ""}
                shapes = weight_shapes("destination", 4)
                PointerNetwork("destination", {key: rng.normal(size=of) for key, of in shapes.items()}).save(file)
            else:
                width = len(columns_of(side))
                Mlp([(rng.normal(size=(len(COMMANDS), width)), np.zeros(len(COMMANDS)))]).save(file)
            file.with_suffix(".py").write_text(AGENT.format(kind="Prey" if side == "prey" else "Agent", **facts))
    return folder


def columns_of(side):
    return (prey_columns if side == "prey" else columns)(scenario("tag"))


def test_each_has_a_name_that_says_what_it_is_and_no_row_among_the_shipped_agents():
    assert ladder_names()
    assert "ladder" not in shipped_names()
    for name in ladder_names():
        _, _, seed, age = name.split("_")
        assert seed.isdigit()
        assert age[:-1].isdigit()
        assert is_shipped(resolve(name).spec)
    assert "ladder." not in command_line.run("agents").stdout
    listed = command_line.run("agents", "--ladder", columns=120).stdout
    assert re.findall(r"ladder\.\w+", listed) == ladder_names()
    assert "Frozen prey of `tag` after " in listed
    size = sum(path.stat().st_size for path in (ROOT / "agents" / "ladder").glob("*.npz"))
    assert size < 1000 * MOST_KB


def test_entrants_have_these_names_and_digests_of_their_own():
    entered = enter(ladder_names())
    assert [one.name for one in entered] == ladder_names()
    assert len({one.digest for one in entered}) == len(entered)
    assert {one.name for one in entered if one.prey} == {name for name in ladder_names() if "_prey_" in name}


def test_an_unknown_one_is_one_line_with_names_like_it():
    with pytest.raises(AgentError, match=r"unknown agent 'ladder.tag_prey_9_1k': did you mean ladder\.\w+"):
        resolve("ladder.tag_prey_9_1k")


def test_they_play_both_sides_of_tag(tmp_path):
    hunter, prey = (next(name for name in ladder_names() if f"tag_{side}_" in name) for side in ("hunters", "prey"))
    config = scenario("tag", time_limit_s=30.0)
    seated = np.zeros((8, config.hunters + config.prey), np.int64)
    found = play_matches(config, {"hunter": [hunter], "prey": [prey]}, seated, 1)
    assert found["times_caught"].sum() == found["score"].sum() > 0
    words = ("tournament", prey, hunter, "nearest", "first", "flee", "--scenario", "tag", "--set", "time_limit_s=5")
    result = command_line.run(*words, "--rounds", "1", "--out", tmp_path, "--jobs", "1")
    assert result.exit_code == 0, result.output
    assert f"flee plays the prey of agents without a class Prey: {hunter}, nearest, first\n" in result.stdout


@pytest.mark.parametrize("network", ["flat", "pointer"])
def test_a_run_becomes_agents_of_the_ages_that_are_asked_for(tmp_path, network, monkeypatch):
    run, out = a_run(tmp_path / "run", network=network), tmp_path / "out"
    out.mkdir()
    names = copy_run(run, [0, 39_000], out)
    assert names == ["tag_hunters_7_0k", "tag_hunters_7_40k", "tag_prey_7_0k", "tag_prey_7_20k"]
    assert copy_run(run, None, out) == ["tag_hunters_7_40k", "tag_prey_7_20k"]
    assert sorted(path.stem for path in out.glob("*.py")) == ["tag_hunters_7_40k", "tag_prey_7_20k"]
    monkeypatch.setattr("catch_arena.agents.ladder.__path__", [str(out)])
    hunters, prey = str(out / "tag_hunters_7_40k.py"), str(out / "tag_prey_7_20k.py")
    config = scenario("tag", time_limit_s=1.0)
    play_matches(config, {"hunter": [hunters], "prey": [prey]}, np.zeros((2, config.hunters + config.prey), int), 1)
    del sys.modules["catch_arena.agents.ladder.tag_hunters_7_40k"]
    kept = create_policy(hunters).network
    before = (Mlp if network == "flat" else PointerNetwork).load(run / "snapshots" / "hunters_40300.npz")
    (ours, theirs) = (
        (kept.layers[0][0], before.layers[0][0]) if network == "flat" else (kept.weights["mix"], before.weights["mix"])
    )
    assert not np.array_equal(ours, theirs)
    np.testing.assert_allclose(ours, theirs, rtol=1e-3)


def test_what_is_no_run_or_of_another_ruleset_is_one_line(tmp_path, monkeypatch, capsys):
    with pytest.raises(FileNotFoundError, match=r"curve\.json"):
        copy_run(tmp_path, None, tmp_path)
    run = a_run(tmp_path / "run", learn=["prey"], ages=(4,))
    file = run / "snapshots" / "prey_2.npz"
    with np.load(file) as tables:
        np.savez(file, **{**tables, "ruleset": "catch_arena_v0"})
    wrong = f"{file}: ruleset must be {RULESET}, got catch_arena_v0; train the network again"
    monkeypatch.setattr("sys.argv", ["ladder.py", str(run), "--out", str(tmp_path / "out")])
    assert LADDER["main"]() == 2
    assert capsys.readouterr().err == f"ladder: {wrong}\n"


def test_weights_that_half_precision_cannot_hold_are_one_line(tmp_path):
    run = a_run(tmp_path / "run", learn=["prey"], ages=(4,))
    Mlp([(np.full((len(COMMANDS), 3), 1e6), np.zeros(len(COMMANDS)))]).save(run / "snapshots" / "prey_2.npz")
    with pytest.raises(ConfigError, match="weights of layer 0 must be finite numbers, got inf"):
        copy_run(run, None, tmp_path)
