"""Commands print, write and exit as docs/reference/command_line.md says."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import run
from isolation_levels import LEVELS

from catch_arena.cli.options import Arena
from catch_arena.errors import ConfigError, MatchFailedError
from catch_arena.scenarios import scenario
from catch_arena.tournament.execution import block_queue
from catch_arena.tournament.isolation.namespaces import level_line
from catch_arena.tournament.players import Players

ROOT = Path(__file__).parents[2]
QUICK = ["--scenario", "duel", "--set", "time_limit_s=3"]


@pytest.mark.parametrize("words", [["--rounds", "1"], ["--until-separated", "0.95"]])
def test_a_round_never_has_more_matches_than_the_user_allows(tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    refused = run("tournament", *["idle"] * 12, *words, "--max-matches", "11")
    assert refused.exit_code == 2
    assert "--max-matches must be at least 12, so that all play equally often, got 11" in refused.stderr


def test_a_tournament_writes_its_files_and_prints_the_table(catch_arena, tmp_path):
    result = catch_arena(
        "tournament", "nearest", "idle", "--rounds", "1", *QUICK, "--jobs", "1", "--out", "o", "--record"
    )
    assert result.exit_code == 0, result.output
    assert re.search(r"1 +nearest +1 +2 ", result.output)
    assert sorted(path.name for path in (tmp_path / "o").iterdir()) == [
        "replays",
        "report.html",
        "standings.csv",
        "standings.json",
        "tournament.sqlite",
    ]
    replays = sorted(map(str, (tmp_path / "o" / "replays").iterdir()))
    assert len(replays) == 2
    verified = catch_arena("verify", *replays)
    assert verified.exit_code == 0
    assert verified.stdout.count("all 30 steps play as recorded") == 2


def test_a_trusted_agent_that_cannot_begin_forfeits_as_an_isolated_one_does(catch_arena, tmp_path):
    (tmp_path / "no_agent.py").write_text("1 / 0\n")
    printed = []
    for words in ([], ["--trusted", "--force"]):
        result = catch_arena("match", "no_agent.py", "nearest", *QUICK, "--seed", "1", *words)
        assert result.exit_code == 0, result.output
        assert "warning: no_agent cannot begin, and forfeits its matches: " in result.stderr
        printed.append(result.stdout.splitlines()[:2])
    assert printed[0] == printed[1]
    assert "FORFEIT_INIT before the first step: " in printed[0][1]


SPOKEN = (
    "class Agent:\n    def reset(self, seed): print('los, 亀')\n    def act(self, view): raise ValueError('zu spät')\n"
)
BAD = ROOT / "tests" / "tournament" / "isolation" / "bad"


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_bad_agents_are_isolated_by_default_and_spoil_nothing(catch_arena, tmp_path, jobs):
    """One ends its process, one is late, one cannot begin, one writes where it plays; the others play on."""
    words = ["nearest", "idle", *(str(BAD / f"{name}.py") for name in ("exits", "hangs", "writes_here"))]
    (tmp_path / "no_agent.py").write_text("1 / 0\n")
    limits = ["--rounds", "1", *QUICK, "--limit", "bank_s=0", "--limit", "step_ms=1000", "--jobs", jobs, "--out", "o"]
    result = catch_arena("tournament", *words, "no_agent.py", "--format", "gauntlet", *limits)
    assert result.exit_code == 0, result.output
    assert "warning: no_agent cannot begin, and forfeits its matches: " in result.stderr
    table = {line.split()[1]: line.split()[-1] for line in result.stdout.splitlines() if re.match(r" *\d ", line)}
    assert table == {"nearest": "0", "idle": "0", "writes_here": "0", "exits": "2", "hangs": "2", "no_agent": "2"}
    logs = {path.name: path.read_text() for path in (tmp_path / "o" / "logs").iterdir()}
    assert logs["exits.log"].count("FORFEIT_CRASH in step 5: act: its process exited with code 3") == 2
    assert logs["hangs.log"].count("FORFEIT_TIMEOUT in step 5: act took longer") == 2
    assert logs["no_agent.log"].count("FORFEIT_INIT before the first step: ") == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["no_agent.py", "o"]
    assert catch_arena("export", "o", "-o", "m.jsonl").exit_code == 0
    details = [one for line in (tmp_path / "m.jsonl").read_text().splitlines() for one in json.loads(line)["details"]]
    assert sum(one is not None for one in details) == 6


def test_a_match_says_who_forfeited_and_what_they_printed(catch_arena):
    result = catch_arena("match", str(BAD / "crashes.py"), "nearest", *QUICK)
    assert result.exit_code == 0, result.output
    assert "crashes (hunter_0): FORFEIT_CRASH in step 5: act raised ZeroDivisionError" in result.stdout
    assert result.stderr.startswith(f"{level_line(LEVELS[0])}\ncrashes printed:\nTraceback")


def test_what_an_agent_printed_that_could_not_begin_is_shown_and_kept(catch_arena, tmp_path):
    (tmp_path / "quits.py").write_text("import os\nos.write(2, b'hello\\nlast line\\n')\nos._exit(7)\n")
    shown = catch_arena("match", "quits.py", "idle", *QUICK)
    assert shown.exit_code == 0, shown.output
    assert 'exited with code 7; its last line: "last line"' in shown.stdout
    assert shown.stderr.endswith("quits printed:\nhello\nlast line\n")
    team = catch_arena("match", "quits.py", "idle", "--scenario", "pairs", "--set", "time_limit_s=1", "-o", "t.replay")
    assert team.stderr.count("hello\nlast line\n") == 1
    catch_arena("tournament", "quits.py", "idle", *QUICK, "--rounds", "1", "--jobs", "1", "--out", "o")
    logged = (tmp_path / "o/logs/quits.log").read_text()
    assert logged.count("\nhello\nlast line\n") == 2


def test_the_result_of_a_match_names_everybody_by_the_seats(catch_arena):
    short = ["--set", "time_limit_s=2", "--set", "reach_m=3.0", "--seed", "3", "--force"]
    hunt = catch_arena("match", "nearest", "nearest", "patrol", "corners", "--scenario", "tag", *short).stdout
    hunters, prey = hunt.split("prey, by number of times caught:")
    assert sorted(re.findall(r"\S+ \(\w+\)", hunters)) == [
        "nearest (hunter_0)",
        "nearest#2 (hunter_1)",
        "patrol (hunter_2)",
    ]
    assert re.search(r"^  1 +\d+  corners \(prey_0\)$", prey, re.MULTILINE)
    teams = catch_arena("match", "nearest", "patrol", "--scenario", "pairs", *short).stdout
    for name, first, second in (("nearest", 0, 1), ("patrol", 2, 3)):
        (found,) = re.findall(
            rf"^ +\d +(\d+)  {name} \(hunter_{first} (\d+) \+ hunter_{second} (\d+)\)$", teams, re.MULTILINE
        )
        assert int(found[0]) == int(found[1]) + int(found[2])


def test_a_match_that_cannot_be_held_is_told_in_one_line_with_what_is_kept(catch_arena, tmp_path):
    (tmp_path / "ends.py").write_text(
        "import os\nclass Agent:\n    def reset(self, seed): os._exit(1)\n    def act(self, view): return 0\n"
    )
    result = catch_arena(
        "tournament", "ends.py", "idle", "--rounds", "1", *QUICK, "--trusted", "--jobs", "2", "--out", "o"
    )
    assert result.exit_code == 2
    *_, error = result.stderr.splitlines()
    assert re.match("error: match r00001-g000001-s00 or .* failed 3 times: a worker process died: .*; what was", error)


@pytest.mark.parametrize("words", [["match", "idle"], ["check-agent"], ["grade", "--spec", "spec.toml"]])
def test_a_match_that_fails_on_our_side_is_played_three_times_at_most(catch_arena, tmp_path, monkeypatch, words):
    (tmp_path / "spec.toml").write_text('title = "t"\nmatches = 1\n[[test]]\nname = "t"\nscenario = "capstone"\n')
    command = [*words, "nearest", *([] if "grade" in words else QUICK)]
    errors, reset = [MatchFailedError("it stood still")] * 2, Players.reset

    def fails(self, *given):
        if errors:
            raise errors.pop()
        return reset(self, *given)

    monkeypatch.setattr(block_queue, "_PAUSE_S", 0.0)
    monkeypatch.setattr(Players, "reset", fails)
    assert catch_arena(*command).exit_code == 0
    errors += [MatchFailedError("it stood still")] * 3
    failed = catch_arena(*command)
    assert (failed.exit_code, failed.stderr, errors) == (2, "error: it stood still\n", [])


def test_it_plays_until_the_order_is_clear_or_the_budget_is_spent(catch_arena):
    words = ["tournament", "nearest", "idle", "-s", "duel", "--set", "time_limit_s=15", "--seed", "0", "--jobs", "1"]
    clear = catch_arena(*words, "--until-separated", "0.95", "--out", "a")
    assert re.search(r"duel: 2 agents, at most 10000 matches", clear.output)
    assert re.search(r"after \d\d matches, the order is clear", clear.output)
    words[2] = "nearest"
    spent = catch_arena(*words, "--until-separated", "0.95", "--max-matches", "21", "--out", "b")
    assert re.search("after 20 matches, nearest.* are not yet significantly different", spent.output)
    more = catch_arena(*words, "--until-separated", "0.95", "--max-matches", "30", "--out", "b", "--resume")
    assert re.search("after 30 matches, nearest.* are not yet significantly different", more.output)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["tournament", "neerest", "idle", *QUICK], "unknown agent 'neerest': did you mean nearest"),
        (["tournament", "nearest", "idle", "--scenario", "dual"], "unknown scenario 'dual': did you mean duel"),
        (["tournament", "nearest", "idle"], "--scenario duel"),
        (["tournament", "nearest", "idle", *QUICK, "--set", "reach=2"], "did you mean reach_m"),
        (["tournament", "nearest", "idle", *QUICK, "--set", "reach_m=-2"], "reach_m must be above 0"),
        (["tournament", "nearest", "idle", *QUICK, "--set", "reach_m"], "--set must be KEY=VALUE"),
        (["tournament", "nearest", "idle", *QUICK, "--set", "control=full"], "each agent declares its own control"),
        (
            ["tournament", "nearest", "idle", *QUICK, "--out", "file/o"],
            "file: cannot be written: is not a folder",
        ),
        (["tournament", "nearest", "idle", *QUICK, "--address", "auto"], "--address must come with --executor ray"),
        (
            ["tournament", "nearest", "idle", *QUICK, "--executor", "ray", "--address", "auto", "-j", "2"],
            "--jobs must be left out with --address",
        ),
        (
            ["tournament", "nearest", "idle", *QUICK, "--until-separated", "0.9", "--max-matches", "200000"],
            "--max-matches must be at most 100000 with --until-separated, got 200000",
        ),
        (["tournament", "nearest", "idle", *QUICK, "--until-separated", "2"], "until_separated must lie in [0.5, 1)"),
        (
            ["tournament", "nearest", "idle", *QUICK, "--until-separated", "0.9", "--rounds", "2"],
            "--rounds must be left out with --until-separated, got 2",
        ),
        (
            ["tournament", "nearest", "idle", *QUICK, "--limit", "steps=9"],
            "unknown limit 'steps': did you mean step_ms",
        ),
        (["match", "nearest", "idle", *QUICK, "--limit", "step_ms=9", "--trusted"], "--limit must be left out with"),
        (["match", "cmd:true", "idle", *QUICK, "--trusted"], "must not be trusted"),
        (["export", "missing", "-o", "e"], "missing: holds no tournament"),
        (["match", "nearest", "idle", "--set", "teams=((0,1),(2,3))"], "or a list such as [[0, 1], [2, 3]], got '((0,"),
        (["match", "nearest", "idle", "--set", "prey_returns_s=None"], "must be a number, a word, true, false, null"),
        (["match", "nearest", "idle", "-s", "tag"], "at least 4 to play the 3 hunters and the 1 prey of tag, got 2"),
        (
            ["tournament", "nearest", "idle", "-s", "tag"],
            "of tag in a tournament (a side with one place needs",
        ),
        (["match", "nearest", "-s", "pairs"], "agents must be at least 2 to play the 2 teams of pairs, got 1"),
        (["compare", "nearest", "idle", "-s", "tag"], "the field (--against) must be of 1 or 3 or 4 agents, got 0: a"),
        (["match", "nearest", *QUICK], "agents must be at least 2"),
        (["match", "nearest", "idle", "first", *QUICK], "agents must be 2"),
        (["match", "nearest", "idle", *QUICK, "--seed", "-1"], "seed must be"),
        (["verify", "missing"], "missing: cannot be read"),
        (["render", "file"], "is not a Catch Arena replay"),
    ],
)
def test_our_errors_are_one_line_and_exit_code_2(catch_arena, tmp_path, words, message):
    (tmp_path / "file").touch()
    result = catch_arena(*words)
    assert result.exit_code == 2
    assert message in result.stderr
    assert "Traceback" not in result.output
    assert result.stderr.strip().splitlines()[-1].startswith("error: ")
    assert sorted(path.name for path in tmp_path.iterdir() if path.name != "out") == ["file"]


def test_agents_and_scenarios_are_listed(catch_arena):
    assert "contested_by_time" in catch_arena("agents").output
    listed = catch_arena("scenarios").output
    assert re.search(r"crowd +16 ", listed)
    settings = {"pairs": "teams=[[0,1],[2,3]]", "tag": "spawning=false", "capstone": "max_speed_mps=31.364114775994008"}
    for name, setting in settings.items():
        assert setting in listed  # whole, and as --set takes it
        field, _, _ = setting.partition("=")
        assert getattr(Arena("standard", [setting]).config(), field) == getattr(scenario(name), field)
    assert re.match(r"catch-arena \d", catch_arena("--version").output)


def test_settings_are_numbers_words_or_parts():
    settings = ["reach_m=0.5", "policy=first_come", "faults.kill_down=0.2", "gains.ki_v=0", "gains.kp_v=3"]
    config = Arena("standard", settings).config()
    assert (config.reach_m, config.policy, config.faults.kill_down) == (0.5, "first_come", 0.2)
    assert (config.gains.ki_v, config.gains.kp_v, config.gains.kp_w) == (0, 3, 6.0)
    with pytest.raises(ConfigError, match=r"unknown setting faults\.kil"):
        Arena("standard", ["faults.kil=1"]).config()


def test_help_loads_nothing_heavy():
    code = (
        "import sys\nfrom typer.testing import CliRunner\nfrom catch_arena.cli import main\n"
        "assert CliRunner().invoke(main, ['--help']).exit_code == 0\n"
        "print([name for name in ('numba', 'pygame', 'cv2', 'av', 'pettingzoo') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.strip() == "[]"


def test_a_plan_is_printed_with_its_cost_before_the_first_match(catch_arena):
    result = catch_arena("tournament", "nearest", "idle", "random", "--rounds", "1", *QUICK, "--record", "--jobs", "2")
    assert result.exit_code == 0, result.output
    for line in (
        r"plan +format round-robin, rounds 1",
        r"matches +6",
        r"an agent plays +4 matches",
        r"a pair meets in +2 matches",
        r"time +about .* with 2 processes",
        r"store +about [\d.]+ kB",
        r"replays +about [\d.]+ kB",
    ):
        assert re.search(line, result.stderr), line


def test_an_interrupt_before_the_first_match_leaves_nothing(catch_arena, tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("catch_arena.cli.tables.plan_table", interrupted)
    catch_arena("tournament", "nearest", "idle", "--rounds", "1", *QUICK)
    assert not list(tmp_path.iterdir())


def test_who_was_out_is_told(catch_arena):
    words = [
        str(BAD / "crashes.py"),
        "idle",
        *QUICK,
        "--rounds",
        "4",
        "--max-forfeits",
        "3",
        "--jobs",
        "1",
        "--out",
        "o",
    ]
    result = catch_arena("tournament", *words, "--trusted")
    assert "crashes was excluded: 4 of its 8 matches were played without it" in result.output
    assert catch_arena("report", "o").exit_code == 0
    assert "FORFEIT_OUT" in Path("o/report.html").read_text()
    assert json.loads(Path("o/standings.json").read_text())["standings"][1]["forfeits"] == {
        "FORFEIT_CRASH": 4,
        "FORFEIT_OUT": 4,
    }


def test_a_tournament_is_not_overwritten_and_is_continued_by_the_same_words_alone(catch_arena, tmp_path):
    first = ["tournament", "nearest", "idle", "--rounds", "1", *QUICK, "--jobs", "1", "--out", "o"]
    begun = catch_arena(*first, "--resume")  # nothing to go on with: it begins
    assert begun.exit_code == 0, begun.output
    content = (tmp_path / "o" / "tournament.sqlite").read_bytes()
    refused = catch_arena(*first)
    assert refused.exit_code == 2
    assert "holds a tournament already, with 2 of 2 matches played: go on with --resume" in refused.stderr
    for more, message in (
        (["--rounds", "2"], "rounds is 1 there, and 2 here"),
        (["--set", "reach_m=0.5"], "reach_m is 0.3 there, and 0.5 here"),
        (["--record"], "recorded is false there, and true here"),
        (["--max-forfeits", "3"], "max_forfeits is 10 there, and 3 here"),
        (["first"], "its agents are nearest idle, and here nearest idle first"),
    ):
        other = catch_arena(*first, "--resume", *more)
        assert (other.exit_code, other.stderr.count("\n")) == (2, 1)
        assert message in other.stderr
    assert catch_arena(*first, "--resume").stdout == begun.stdout
    assert (tmp_path / "o" / "tournament.sqlite").read_bytes() == content


@pytest.mark.parametrize(
    ("settings", "shown"),
    [({"LC_ALL": "C"}, "jäger_亀"), ({"LANG": "C"}, "jäger_亀"), ({"PYTHONIOENCODING": "ascii"}, "j?ger_?")],
)
def test_names_of_any_script_play_and_are_written_whatever_the_terminal_can_show(tmp_path, settings, shown):
    folder = tmp_path / "Zoë Müller"
    folder.mkdir()
    (folder / "jäger_亀.py").write_text(SPOKEN, encoding="utf-8")
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith(("LANG", "LC_", "PYTHONIO"))
    }
    words = [
        sys.executable,
        "-m",
        "catch_arena",
        "tournament",
        "Zoë Müller/jäger_亀.py",
        "nearest",
        "--rounds",
        "1",
        *QUICK,
        "--limit",
        "init_s=120",
        "--jobs",
        "2",
        "--record",
        "--out",
        "größe",
    ]
    done = subprocess.run(
        words, cwd=tmp_path, env={**environment, **settings}, capture_output=True, encoding="utf-8", check=False
    )
    assert done.returncode == 0, done.stderr
    assert level_line(LEVELS[0]) in " ".join(done.stderr.split())
    assert re.search(rf"2 *\|? *{re.escape(shown)} ", done.stdout), done.stdout
    assert "act raised ValueError: zu spät" in (tmp_path / "größe" / "logs" / "jäger_亀.log").read_text(
        encoding="utf-8"
    )
    assert "los, 亀" in (tmp_path / "größe" / "logs" / "jäger_亀.log").read_text(encoding="utf-8")
    assert "jäger_亀" in (tmp_path / "größe" / "report.html").read_text(encoding="utf-8")
    assert "jäger_亀,1," in (tmp_path / "größe" / "standings.csv").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (b"caf\xe9.py", r"must be text in this system's encoding, utf-8: "),
        (b"a\nb.py", r"its name must have 1 to"),
    ],
)
def test_a_name_that_is_no_text_is_one_line(catch_arena, tmp_path, name, message):
    (tmp_path / os.fsdecode(name)).write_text(SPOKEN, encoding="utf-8")
    for words in (["tournament", "{}", "nearest"], ["match", "{}", "nearest"], ["check-agent", "{}"]):
        refused = catch_arena(*(os.fsdecode(name) if word == "{}" else word for word in words), *QUICK)
        assert (refused.exit_code, refused.stderr.count("\n")) == (2, 1)
        assert message in refused.stderr
