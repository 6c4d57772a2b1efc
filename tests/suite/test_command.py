"""`catch-arena suite` prints its plan, computes its numbers, and resumes."""

import dataclasses
import json
import re
import shutil

import command_line
import numpy as np
import pytest
from tournament.played_matches import made_up

from catch_arena.scenarios import scenario
from catch_arena.suite import contents
from catch_arena.suite.contents import Suite, SuiteScenario
from catch_arena.suite.measures import AgentMeasures, measure, measure_scenario, over_training_runs
from catch_arena.suite.tournaments import play, tournaments
from catch_arena.tournament.match import MoveTimes
from catch_arena.tournament.players import enter
from catch_arena.training import Mlp

SHORT = {"time_limit_s": 3.0}
SMALL = Suite(
    name="small_v1",
    scenarios=(
        SuiteScenario("duel", scenario("duel", **SHORT), ("nearest", "first"), held_out=False, description="two"),
        SuiteScenario("four", scenario("standard", **SHORT), ("first", "contested"), held_out=True, description="four"),
        SuiteScenario("pairs", scenario("pairs", **SHORT), ("nearest",), held_out=True, description="teams"),
    ),
    blocks=4,
    seed=5,
)
SIZE = 4 * (2 + 4 + 2)
NARROW = """
from pathlib import Path
import numpy as np
from catch_arena.training import Mlp, fit_mask, fit_observation
class Agent:
    def __init__(self):
        self.network = Mlp.load(Path(__file__).parent / "mine.npz")
    def reset(self, seed): pass
    def act(self, view):
        return int(np.where(view.mask, self.network(view.observation), -np.inf).argmax())
"""
FITTED = NARROW.replace("view.mask", 'fit_mask(view, "standard")').replace(
    "view.observation", 'fit_observation(view, "standard")'
)


@pytest.fixture
def run(monkeypatch, tmp_path):
    monkeypatch.setattr(contents, "SUITE", SMALL)
    monkeypatch.chdir(tmp_path)

    def run(*words):
        return command_line.run("suite", "--jobs", "1", *words, columns=100)

    return run


def test_a_run_says_what_it_plays_before_and_keeps_all_of_it(run, tmp_path):
    result = run("contested", "--json", "numbers.json")
    assert result.exit_code == 0, result.output
    assert f"small_v1 (digest {SMALL.digest}): 3 scenarios, 4 blocks of each" in result.stdout
    assert f"1 agent, {SIZE} matches, with one process" in result.stdout
    assert "cannot play" not in result.output
    assert "NOT the protocol" not in result.output
    for name in ("duel", "four", "pairs"):
        assert (tmp_path / "out/suite/contested" / name / "tournament.sqlite").exists()
        assert re.search(rf"^ +{name} +[01]\.\d\d +", result.stdout, re.MULTILINE)
    (figures,) = json.loads((tmp_path / "numbers.json").read_text())["agents"]
    assert figures["suite_digest"] == SMALL.digest
    assert figures["is_protocol"]
    assert sum(one["matches"] for one in figures["scenarios"].values()) == SIZE
    assert f"interquartile mean, held out: {figures['iqm']['held_out']['mean']:.3f} (" in result.stdout


def test_it_goes_on_where_it_was_and_ends_with_the_same(run, tmp_path):
    assert run("contested", "--json", "one.json").exit_code == 0
    again = run("contested")
    assert again.exit_code == 2
    assert again.stderr == (
        "error: out/suite/contested/duel/tournament.sqlite: holds a tournament already, with 8 of 8 matches played: "
        "go on with --resume, or give another folder\n"
    )
    shutil.rmtree(tmp_path / "out/suite/contested/four")
    resumed = run("contested", "--resume", "--json", "two.json")
    assert resumed.exit_code == 0, resumed.output
    one, two = ((tmp_path / name).read_text() for name in ("one.json", "two.json"))
    assert without_times(one) == without_times(two)
    assert run("contested", "--resume").exit_code == 0


def test_each_scenario_is_what_the_command_tournament_plays_in_its_folder(run, tmp_path):
    """A folder with other files is refused before any match, and afterwards each has the files of a tournament."""
    mine = tmp_path / "out/suite/contested/pairs/standings.csv"
    mine.parent.mkdir(parents=True)
    mine.write_text("mine")
    refused = run("nearest", "contested")
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert refused.stderr == (
        "error: out/suite/contested/pairs: has other files; use --force to write into it, or choose another folder\n"
    )
    assert mine.read_text() == "mine"
    assert run("nearest", "contested", "--force").exit_code == 0
    for name, matches in (("duel", 8), ("four", 16), ("pairs", 8)):
        folder = tmp_path / "out/suite/contested" / name
        assert json.loads((folder / "standings.json").read_text())["matches"] == matches
        assert command_line.run("report", str(folder)).exit_code == 0


def test_a_first_look_is_the_beginning_of_the_protocol_in_one_folder(run, tmp_path):
    assert run("contested", "--out", "o", "--json", "whole.json").exit_code == 0
    assert run("contested", "--out", "two", "--quick", "--json", "quick.json").exit_code == 0
    assert run("contested", "--out", "o", "--quick", "--resume", "--json", "first.json").exit_code == 0
    assert run("contested", "--out", "two", "--resume", "--json", "grown.json").exit_code == 0
    whole, quick, first, grown = (
        without_times((tmp_path / f"{name}.json").read_text()) for name in ("whole", "quick", "first", "grown")
    )
    assert quick == first != whole == grown


def without_times(text):
    return re.sub(r'"move_ms": [\d.]+', '"move_ms": 0', text)


def test_who_cannot_read_a_width_is_told_before_any_match_and_one_that_fits_it_plays(run, tmp_path):
    rng = np.random.default_rng(1)
    Mlp([(rng.normal(size=(9, 71)), np.zeros(9))]).save(tmp_path / "mine.npz")
    (tmp_path / "mine.py").write_text(NARROW)
    result = run("mine.py", "--trusted", "--quick")
    assert result.exit_code == 0, result.output
    warned = [line for line in result.stderr.splitlines() if "cannot play" in line]
    needed = "act raised ConfigError: observations must have 71 columns for this network, got"
    assert warned == [
        f"mine cannot play duel, and forfeits there: {needed} the shape (57,)",
        f"mine cannot play pairs, and forfeits there: {needed} the shape (74,)",
    ]
    assert "NOT the protocol" in result.stdout
    assert re.search(r"^ +duel +0\.00 .* no +4 *$", result.stdout, re.MULTILINE)  # it forfeits all, and is not first
    assert re.search(r"^ +four .* \? +0 *$", result.stdout, re.MULTILINE)  # two blocks do not tell
    (tmp_path / "fitted.py").write_text(FITTED)
    result = run("fitted.py", "--quick", "--trusted")
    assert result.exit_code == 0, result.output
    assert "cannot play" not in result.output


def test_one_that_cannot_begin_is_told_once(run, tmp_path):
    (tmp_path / "mine.py").write_text("import rclpy\nclass Agent: pass\n")
    result = run("mine.py", "--quick")
    assert result.exit_code == 0, result.output
    assert result.stderr.count("it imports rclpy, which is not installed here") == 1  # as for every command
    assert "warning: mine cannot begin, and forfeits its matches: " in result.stderr
    assert "intervals (? below) need 4 blocks\n" in result.stdout
    assert "time: it made no move\n" in result.stdout


def test_another_suite_is_played_by_its_name_in_a_folder_of_its_own(run, tmp_path, monkeypatch):
    monkeypatch.setattr(contents, "LADDER", dataclasses.replace(SMALL, name="other_v1"))
    assert run("contested", "--quick").exit_code == 0
    result = run("contested", "--quick", "--suite", "other_v1", "--json", "other.json")
    assert result.exit_code == 0, result.output
    assert "other_v1 (digest " in result.stdout
    assert (tmp_path / "out/other_v1-quick/contested/four/tournament.sqlite").exists()
    (figures,) = json.loads((tmp_path / "other.json").read_text())["agents"]
    assert figures["suite"] == "other_v1"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nearst"], "unknown agent 'nearst': did you mean nearest"),
        (["nearest", "--json", "there.json"], "there.json: already exists; use --force"),
        (["nearest", "--suite", "ladder"], "unknown suite 'ladder': known: catch_arena_ladder_v1, small_v1"),
        (["nearest", "--out", "there.json"], "there.json: cannot be written: is not a folder"),
    ],
)
def test_words_that_cannot_be_are_one_line_and_exit_code_2(run, tmp_path, words, message):
    (tmp_path / "there.json").write_text("{}")
    result = run(*words)
    assert result.exit_code == 2
    assert message in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert not (tmp_path / "out" / "suite" / "nearest").exists()


def played(block, party, scores, *, forfeits=()):
    """A match of three, with the agent in this party."""
    others = iter((1, 2))
    seating = tuple(0 if place == party else next(others) for place in range(3))
    codes = tuple("FORFEIT_CRASH" if place in forfeits else None for place in range(3))
    thinking = (MoveTimes(10, 0.02, 0.01),) * 3
    return made_up(block, seating, scores, party, forfeits=codes, thinking=thinking)


@pytest.mark.parametrize(
    ("block", "score"),
    [
        ([(0, (6, 3, 3))], 6 / 9),
        ([(0, (6, 3, 3)), (1, (1, 0, 5)), (2, (2, 2, 2))], 8 / (8 + 16 / 2)),
        ([(1, (0, 0, 0))], 0.5),
        ([(2, (4, 2, 0))], 0.0),
        ([(1, (0, 7, 0))], 1.0),
    ],
)
def test_the_normalised_score_is_its_share_beside_the_mean_opponent(block, score):
    assert measured([[played(0, party, scores) for party, scores in block]]).by_block == (pytest.approx(score),)


def test_what_was_caught_in_a_forfeited_match_does_not_count():
    block = [played(0, 0, (6, 3, 3), forfeits=[0]), played(0, 1, (2, 2, 2))]
    of = measured([block])
    assert of.by_block == (pytest.approx(2 / (2 + 10 / 2)),)
    assert of.forfeits == {"FORFEIT_CRASH": 1}
    assert measured([[played(0, 0, (0, 0, 0), forfeits=[0])]]).by_block == (0.0,)
    assert measured([[played(0, 0, (0, 0, 0), forfeits=[0])]]).first is False


def measured(blocks):
    one = SuiteScenario("three", scenario("standard", hunters=3), ("first", "random"), held_out=False, description="")
    return measure_scenario(one, enter(["nearest", "first", "random"]), [match for block in blocks for match in block])


def rotated(scores):
    """A block's three matches on the same targets: (agent, others) as the agent moves through the seats."""
    return [
        (party, tuple(np.insert(others, party, own).tolist()))
        for party, (own, others) in zip(range(3), scores, strict=True)
    ]


def field(seed, strengths, blocks=10):
    """Blocks of three, whose catches are Poisson's."""
    rng = np.random.default_rng(seed)
    return [
        [
            played(block, *one)
            for one in rotated([(rng.poisson(strengths[0]), rng.poisson(strengths[1:])) for _ in range(3)])
        ]
        for block in range(blocks)
    ]


@pytest.mark.parametrize(
    ("strengths", "first"), [((20, 8, 8), True), ((8, 20, 8), False), ((0, 9, 9), False), ((9, 9, 2), None)]
)
def test_whether_it_comes_first_is_told_where_it_is_sure(strengths, first):
    assert measured(field(1, strengths)).first is first


def test_the_best_is_first_and_the_worst_last(tmp_path):
    best, worst = (measured_in_all(agent, tmp_path) for agent in enter(["patrol", "idle"]))
    for one in worst.scenarios:
        assert one.place == one.of
        assert one.first is False
        assert one.score.mean == 0
        assert one.win_share.mean <= 0.25  # short matches may end without a catch
    assert best.training.mean > worst.training.mean
    assert best.improvement(scores_of(worst), held_out=True).mean == 1
    assert worst.improvement(scores_of(best), held_out=False).mean == 0
    assert best.improvement(scores_of(best), held_out=True).mean == 0.5


def measured_in_all(agent, out):
    setups = tournaments(SMALL, agent, out, 4, None)
    play(setups, 1, lambda *_: None)
    return measure(SMALL, setups)


def scores_of(measures):
    return {one.name: one.by_block for one in measures.scenarios}


def test_the_gap_is_what_is_lost_in_held_out_scenarios():
    known, unknown = (measured([[played(block, 0, (score, 4, 4))] for block in range(4)]) for score in (6, 2))
    (agent,) = enter(["nearest"])
    both = AgentMeasures(agent, 4, (known, dataclasses.replace(unknown, held_out=True)))
    assert both.training.mean == pytest.approx(0.6)
    assert both.held_out.mean == pytest.approx(1 / 3)
    assert both.gap.mean == pytest.approx(0.6 - 1 / 3)
    runs = [both, both, AgentMeasures(agent, 4, (unknown, dataclasses.replace(known, held_out=True)))]
    assert over_training_runs(runs, held_out=False).mean == pytest.approx(np.mean([0.6, 0.6, 1 / 3]))


def test_references_are_compared_with_block_by_block(run, tmp_path, monkeypatch):
    """The references have the format that the command writes."""
    path = tmp_path / "references.json"
    assert run("nearest", "--json", "references.json").exit_code == 0
    monkeypatch.setattr("catch_arena.suite.measures.references.__defaults__", (path,))
    result = run("nearest", "--resume", "--json", "numbers.json")
    (figures,) = json.loads((tmp_path / "numbers.json").read_text())["agents"]
    of = figures["probability_of_improvement"]["nearest"]
    assert of["training"]["mean"] == of["held_out"]["mean"] == 0.5  # itself
    assert "probability of improvement over nearest: training 0.50" in result.stdout
