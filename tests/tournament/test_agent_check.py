"""`catch-arena check-agent` says what is wrong with an agent, and exits with 1."""

import re

import pytest
from command_line import run

from catch_arena.scenarios import SCENARIOS

QUICK = ["--scenario", "duel", "--set", "time_limit_s=3"]
HEAD = "class Agent:\n    def reset(self, seed): pass\n    def act(self, view):\n        "


@pytest.fixture
def check(tmp_path):
    def call(source, *words):
        spec = source
        if "\n" in source:
            spec = tmp_path / "mine.py"
            spec.write_text(source)
        return run("check-agent", spec, *(words or QUICK), columns=500)

    return call


def test_a_good_agent_is_fit_in_every_scenario(check):
    result = check("patrol", "--set", "time_limit_s=3", "--limit", "step_ms=60000")  # however busy the machine is
    assert result.exit_code == 0, result.output
    for scenario in ("standard", "duel", "crowd", "scarce", "faulty", "capstone"):
        assert re.search(
            rf"^ok: +{scenario}: 30 steps; its [^;]*score[^;]* [\d, ]+; [\d.]+ ms a step", result.output, re.MULTILINE
        )
    assert "standard: plays the same match again" in result.output
    assert result.stdout.endswith("patrol is fit to play\n")
    assert "warning" not in result.output


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("class Agnet: pass\n", ["cannot begin: ", "has no class Agent; did you mean Agnet"]),
        ("import rclpy.node\n", ["it imports rclpy, which is not installed here", "| ModuleNotFoundError"]),
        (
            HEAD.replace("self, view", "self") + "return 0\n",
            ["act raised TypeError: Agent.act() takes 1 "],
        ),
        (HEAD + "return 99\n", ["FORFEIT_ILLEGAL in step 1: an action must be", "it saw: targets 1: ", "mask [1, 1, "]),
        (HEAD + "return view.targets[40].rank\n", ["FORFEIT_CRASH in step 1: act raised IndexError", "| IndexError:"]),
    ],
)
def test_what_would_forfeit_is_explained_and_the_exit_code_is_1(check, source, words):
    result = check(source)
    assert result.exit_code == 1
    for word in words:
        assert word in result.output, result.output
    assert "fit to play" not in result.output
    assert "plays the same match again" not in result.output


def test_a_trusted_one_that_cannot_begin_is_explained_too(check):
    result = check("class Agnet: pass\n", *QUICK, "--trusted")
    assert result.exit_code == 1
    assert re.search(r"^error: +cannot begin: .*did you mean Agnet\?\n$", result.stdout)


def test_one_that_hangs_is_tried_in_two_arenas(check):
    result = check(HEAD + "while True: pass\n", "--limit", "step_ms=50", "--limit", "bank_s=0")
    assert result.exit_code == 1
    assert result.output.count("error: ") == 2
    left = [name for name in SCENARIOS if f"error:   {name}: FORFEIT_TIMEOUT" not in result.output]
    assert f"was too slow in 2 arenas, and not tried in: {', '.join(left)}\n" in result.output


def test_one_that_fails_in_one_scenario_is_played_again_in_another(check):
    words = ["-s", "standard", "-s", "duel", "--set", "time_limit_s=3"]
    result = check(HEAD + "return 99 if len(view.rivals) > 1 else 0\n", *words)
    assert "standard: FORFEIT_ILLEGAL" in result.output
    assert "duel: plays the same match again" in result.output


def test_one_that_fails_without_a_target_is_shown_that_it_saw_none(check):
    result = check(HEAD + "return view.targets[0].rank\n", "--scenario", "scarce", "--set", "time_limit_s=3")
    assert result.exit_code == 1
    assert "it saw: targets none (view.targets is empty); rivals 3; mask " in result.output


def test_of_a_team_that_prints_the_text_is_shown_and_not_the_name_of_the_seat(check):
    result = check(HEAD + "print('look')\n        return 0\n", "-s", "pairs", "--set", "time_limit_s=1")
    assert "warning: pairs: prints, which goes to its log: 'look'\n" in result.output


def test_the_same_failure_in_another_scenario_is_told_in_one_line(check):
    result = check(HEAD + "return 99\n", "-s", "standard", "-s", "duel", "--set", "time_limit_s=3")
    assert len(re.findall(r"^error: +\w+: FORFEIT_ILLEGAL in step 1: ", result.output, re.MULTILINE)) == 2
    assert result.stdout.count("it saw: ") == 1


@pytest.mark.parametrize(
    ("source", "words"),
    [
        (HEAD + "print('look', view.score)\n        return 0\n", "prints, which goes to its log: 'look 0.0'"),
        (f"import time\n{HEAD}time.sleep(0.03)\n        return 0\n", "is too slow: "),
        (f"import os\n{HEAD}return os.urandom(1)[0] % 2\n", "plays another match, given the same seed: "),
        (HEAD + "return 8\n", "requests were MALFORMED: the requested name cannot be a target's name (R5.2)"),
    ],
)
def test_what_is_only_unwise_is_a_warning(check, source, words):
    result = check(source, *QUICK, "--limit", "step_ms=20")
    assert result.exit_code == 0, result.output
    assert re.search(rf"^warning: duel: .*{re.escape(words)}", result.output, re.MULTILINE), result.output
