"""Commands that take more than seconds print their progress."""

import re

import pytest

from catch_arena.cli import terminal

QUICK = ["--set", "time_limit_s=1"]
DUEL = ["--scenario", "duel", *QUICK]


@pytest.mark.parametrize(
    ("words", "what", "lines"),
    [
        (["match", "nearest", "idle", *DUEL], "playing", range(11)),
        (["match", "nearest", "idle", *DUEL], "loading agents", [1, 2]),
        (["check-agent", "nearest", "-s", "duel", "-s", "standard", *QUICK], "playing", range(3)),
        (["conformance", "catch_arena:arbitrate", "--only", "basics"], "cases", None),
        (["compare", "nearest", "idle", *QUICK, "--jobs", "1", "--max-blocks", "1"], r"H0 \S+ < .+ H1", [2]),
        (["tournament", "nearest", "idle", *DUEL, "--rounds", "2", "--jobs", "1"], "playing", [0, 2, 4]),
    ],
)
def test_how_far_it_is_stands_on_stderr(catch_arena, monkeypatch, words, what, lines):
    monkeypatch.setattr(terminal, "_LINE_EVERY_S", 0.0)
    result = catch_arena(*words)
    found = re.findall(rf"^{what}: (\d+) of (\d+), \d+ s(, about \d+ s left)?$", result.stderr, re.MULTILINE)
    assert found, result.output
    assert all(bool(left) == (done != "0") for done, _, left in found)  # nothing is known before
    every = range(1, int(found[-1][1]) + 1)
    assert [int(done) for done, *_ in found] == list(every if lines is None else lines)
