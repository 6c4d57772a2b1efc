"""Every attack of the table is tried by a real agent, at both levels of isolation."""

import dataclasses
import os
from pathlib import Path

import pytest
from tournament.attacks.harness import Host
from tournament.attacks.table import AS_ROOT, ATTACKS, BY_LUCK, BY_SOME_KERNELS, LEVELS, NOT_STOPPED, STOPPED

PAGE = Path(__file__).parents[3] / "docs" / "attacks.md"


@pytest.fixture(scope="module")
def host():
    with Host() as started:
        yield started


@pytest.fixture(scope="module")
def probes(host, tmp_path_factory):
    """What came of all attacks that only look, by level."""
    first, *others = [one for one in ATTACKS if one.together]
    found = {}

    def outcome(level):
        if level not in found:
            found[level] = host.attempt(first, level, tmp_path_factory.mktemp(level) / "world", also=others)
        return found[level]

    return outcome


@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.name)
@pytest.mark.parametrize("level", LEVELS)
def test_it_is_stopped_where_the_table_says_so_and_nowhere_else(host, probes, tmp_path, level, attack):
    if attack.together:
        outcome = dataclasses.replace(probes(level), tried=attack.run.__name__)
    else:
        outcome = host.attempt(attack, level, tmp_path / "world")
    expected = getattr(attack, level)
    succeeded = attack.succeeded(outcome)
    if expected == STOPPED or (expected == AS_ROOT and os.geteuid() != 0):
        assert not succeeded, outcome
        assert not outcome.broken, outcome
    elif expected == NOT_STOPPED:
        assert succeeded, outcome
    else:
        assert expected in {AS_ROOT, BY_LUCK, BY_SOME_KERNELS}
