"""The command line: what it prints, what it leaves, and its exit codes."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from catch_arena.cli import arena, main
from catch_arena.errors import ConfigError

ROOT = Path(__file__).parents[2]
QUICK = ["--scenario", "duel", "--set", "time_limit_s=3"]


@pytest.fixture
def catch_arena(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def call(*words: str):
        return CliRunner().invoke(main, list(words))

    return call


def test_a_tournament_writes_its_files_and_prints_the_table(catch_arena, tmp_path):
    result = catch_arena("tournament", "nearest", "idle", *QUICK, "--jobs", "1", "--out", "o", "--record", "o/replays")
    assert result.exit_code == 0, result.output
    assert re.search(r"1 +nearest +2 ", result.output)
    assert sorted(path.name for path in (tmp_path / "o").iterdir()) == [
        "replays",
        "results.jsonl",
        "standings.csv",
        "standings.json",
    ]
    replays = sorted(map(str, (tmp_path / "o" / "replays").iterdir()))
    assert len(replays) == 2
    verified = catch_arena("verify", *replays)
    assert verified.exit_code == 0
    assert verified.output.count("all of 30 steps play as recorded") == 2


def test_no_line_of_the_table_is_longer_than_80_columns(catch_arena):
    result = catch_arena("tournament", "contested_by_time", "contested_by_time", *QUICK, "--jobs", "1", "--out", "o")
    assert max(map(len, result.output.splitlines())) <= 80
    assert "contested_by_time#2" in result.output


def test_a_match_is_recorded(catch_arena, tmp_path):
    result = catch_arena("match", "nearest", "patrol", *QUICK, "--seed", "4", "-o", "m.replay")
    assert result.exit_code == 0, result.output
    assert (tmp_path / "m.replay").is_file()


def test_a_damaged_replay_is_reported_and_the_others_are_still_checked(catch_arena, tmp_path):
    catch_arena("match", "nearest", "patrol", *QUICK, "-o", "m.replay")
    (tmp_path / "bad.replay").write_bytes((tmp_path / "m.replay").read_bytes()[:-3])
    result = catch_arena("verify", "bad.replay", "m.replay")
    assert result.exit_code == 2
    assert "bad.replay: should be" in result.stderr
    assert "m.replay: all of 30 steps" in result.stdout


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["tournament", "neerest", "idle", *QUICK], "unknown agent 'neerest': did you mean nearest"),
        (["tournament", "nearest", "idle", "--scenario", "dual"], "unknown scenario 'dual': did you mean duel"),
        (["tournament", "nearest", "idle"], "--scenario duel"),
        (["tournament", "nearest", "idle", *QUICK, "--set", "reach=2"], "did you mean reach_m"),
        (["tournament", "nearest", "idle", *QUICK, "--set", "reach_m=-2"], "reach_m must be above 0"),
        (["tournament", "nearest", "idle", *QUICK, "--set", "reach_m"], "--set must be KEY=VALUE"),
        (["tournament", "nearest", "idle", *QUICK, "--set", "control=full"], "left to the agents"),
        (["tournament", "nearest", "idle", *QUICK, "--jobs", "0"], "jobs must be at least 1"),
        (["tournament", "nearest", "idle", *QUICK, "--rounds", "0"], "rounds must be at least 1"),
        (["tournament", "nearest", "idle", *QUICK, "--out", "file/o"], "file/o: cannot be written to"),
        (["match", "nearest", *QUICK], "agents must be at least 2"),
        (["match", "nearest", "idle", "first", *QUICK], "agents must be 2"),
        (["match", "nearest", "idle", *QUICK, "-o", "file/m.replay"], "file: cannot be written to"),
        (["match", "nearest", "idle", *QUICK, "--seed", "-1"], "seed must be"),
        (["verify", "file"], "is not a Catch Arena replay"),
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
    assert result.stderr.strip().splitlines()[-1].startswith("catch-arena: ")
    assert sorted(path.name for path in tmp_path.iterdir() if path.name != "out") == ["file"]


@pytest.mark.parametrize(
    ("words", "message"),
    [(["tornament"], "tournament"), (["tournament", "nearest", "--secnario", "duel"], "--scenario")],
)
def test_a_mistyped_command_or_option_is_suggested(catch_arena, words, message):
    result = catch_arena(*words)
    assert result.exit_code == 2
    assert message in result.stderr


def test_agents_and_scenarios_are_listed(catch_arena):
    assert "contested_by_time" in catch_arena("agents").output
    assert re.search(r"crowd +16 ", catch_arena("scenarios").output)
    assert re.match(r"catch-arena \d", catch_arena("--version").output)


def test_settings_are_numbers_words_or_parts():
    config = arena(
        "standard", ["reach_m=0.5", "policy=first_come", "faults.kill_down=0.2", "gains.ki_v=0", "gains.kp_v=3"]
    )
    assert (config.reach_m, config.policy, config.faults.kill_down) == (0.5, "first_come", 0.2)
    assert (config.gains.ki_v, config.gains.kp_v, config.gains.kp_w) == (0, 3, 6.0)
    with pytest.raises(ConfigError, match=r"unknown setting faults\.kil"):
        arena("standard", ["faults.kil=1"])


def test_help_loads_nothing_heavy():
    code = (
        "import sys\nfrom typer.testing import CliRunner\nfrom catch_arena.cli import main\n"
        "assert CliRunner().invoke(main, ['--help']).exit_code == 0\n"
        "print([name for name in ('numba', 'pygame', 'cv2', 'av', 'pettingzoo') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout.strip() == "[]"


def test_the_script_is_the_command(tmp_path):
    words = ["nearest", "idle", *QUICK, "--jobs", "1"]
    outputs = [
        subprocess.run(
            [*command, *words, "--out", name], cwd=tmp_path, check=True, capture_output=True, text=True
        ).stdout
        for name, command in {
            "a": [sys.executable, str(ROOT / "scripts" / "tournament.py")],
            "b": [sys.executable, "-c", "from catch_arena.cli import main; main()", "tournament"],
        }.items()
    ]
    assert outputs[0].replace("results: a", "results: b") == outputs[1]
    assert (tmp_path / "a" / "results.jsonl").read_bytes() == (tmp_path / "b" / "results.jsonl").read_bytes()


def test_ctrl_c_ends_it_with_130_and_no_results(tmp_path):
    hang = tmp_path / "hang.py"
    hang.write_text(
        "from pathlib import Path\nclass Agent:\n    def reset(self, seed): Path('began').touch()\n"
        "    def act(self, view):\n        while True: pass\n"
    )
    command = [sys.executable, "-c", "from catch_arena.cli import main; main()", "tournament", "hang.py", "idle"]
    process = subprocess.Popen(
        [*command, "--scenario", "duel", "--jobs", "2", "--out", "o"], cwd=tmp_path, stderr=subprocess.PIPE, text=True
    )
    patience = time.monotonic() + 60
    while not (tmp_path / "began").exists() and time.monotonic() < patience:
        time.sleep(0.05)
    os.kill(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 130
    assert errors.strip().splitlines()[-1] == "catch-arena: interrupted"
    assert not list((tmp_path / "o").iterdir())
