"""One trust rule: what does not come with the package is isolated by every command that runs agents, unless --trusted.

The agent writes to the file that an environment variable names. Only an agent inside our own processes has our
environment: an isolated one has one of its own.
"""

import command_line
import pytest

from catch_arena.render.optional_imports import pygame
from catch_arena.scenarios import scenario
from catch_arena.suite.contents import Suite, SuiteScenario

pytestmark = pytest.mark.usefixtures("without_a_screen")
MARK = "CATCH_ARENA_TEST_MARK"
AGENT = f"""
import os
from pathlib import Path
from catch_arena.agents.nearest import Agent as Nearest
if "{MARK}" in os.environ:
    Path(os.environ["{MARK}"]).touch()
class Agent(Nearest):
    pass
"""
SPEC = """
seed = 1

[[test]]
name = "it plays"
scenario = "duel"
settings = { time_limit_s = 1 }
opponents = ["nearest"]
matches = 1
"""
SMALL_SUITE = Suite(
    "small",
    tuple(
        SuiteScenario(
            name, scenario("duel", time_limit_s=1.0), ("nearest",), held_out=name == "unknown", description=""
        )
        for name in ("known", "unknown")
    ),
    blocks=4,
    seed=1,
)
SHORT = ["--scenario", "duel", "--set", "time_limit_s=1"]
RUNS = {
    "tournament": ["{}", "nearest", *SHORT, "--rounds", "1", "--jobs", "1", "--out", "out"],
    "match": ["{}", "nearest", *SHORT],
    "compare": ["{}", "nearest", *SHORT, "--jobs", "1", "--max-blocks", "1"],
    "check-agent": ["{}", *SHORT],
    "suite": ["{}", "--quick", "--jobs", "1"],
    "grade": ["{}", "--spec", "spec.toml"],
    "play": ["{}", *SHORT],
    "watch": ["{}", "nearest", *SHORT],
    "ros serve": ["--seat", "0={}", "--seat", "1=nearest", *SHORT, "--speed", "10"],
}
"""Each command that runs agents, and what it is given."""
EXIT_CODES = {"compare": {0, 1, 3}}


@pytest.fixture
def run(monkeypatch, tmp_path):
    """Runs a command with the agent; whether the agent was in one of our own processes."""
    monkeypatch.setattr("catch_arena.suite.contents.SUITE", SMALL_SUITE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROS_LOCALHOST_ONLY", "1")
    monkeypatch.setenv("ROS_DOMAIN_ID", "93")
    monkeypatch.setenv(MARK, str(tmp_path / "mark"))
    (tmp_path / "mine.py").write_text(AGENT)
    (tmp_path / "spec.toml").write_text(SPEC)
    looks = iter(range(10**9))
    escape = pygame.event.Event(pygame.KEYDOWN, key=pygame.K_ESCAPE, mod=0, unicode="")
    begin = pygame.event.Event(pygame.KEYDOWN, key=pygame.K_x, mod=0, unicode="x")
    monkeypatch.setattr(pygame.event, "get", lambda: [begin] if (look := next(looks)) == 0 else [escape] * (look > 200))

    def run(name: str, agent: str, *more: str) -> bool:
        command, *options = name.split()
        words = [word.replace("{}", agent) for word in RUNS[name]]
        result = command_line.run(command, *options, *words, *more)
        assert result.exit_code in EXIT_CODES.get(command, {0}), result.output
        assert "FORFEIT" not in result.output
        return (tmp_path / "mark").exists()

    return run


AGAIN = {"match": ["--force"], "tournament": ["--out", "trusted"], "suite": ["--out", "trusted"]}
"""Options that let a command run twice in one folder."""


@pytest.mark.parametrize(
    ("name", "module"), [*((name, False) for name in RUNS), *((name, True) for name in ("match", "watch"))]
)
def test_an_agent_in_a_file_or_a_module_is_isolated_unless_it_is_trusted(run, tmp_path, monkeypatch, name, module):
    """A module may be a stranger's as well."""
    (tmp_path / "installed").mkdir()
    monkeypatch.syspath_prepend(tmp_path / "installed")
    (tmp_path / "installed" / f"theirs_{name}.py").write_text(AGENT)
    spec = f"theirs_{name}:Agent" if module else "mine.py"
    assert not run(name, spec)
    assert run(name, spec, "--trusted", *AGAIN.get(name, []))
