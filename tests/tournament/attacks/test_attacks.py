"""Every attack of the table is tried by a real agent, at both levels of isolation."""

import dataclasses
import os
from pathlib import Path

import pytest
from isolation_levels import LEVELS
from tournament.attacks.harness import Host
from tournament.attacks.table import (
    AS_ROOT,
    ATTACKS,
    BY_LUCK,
    BY_SOME_KERNELS,
    GROUPS_STOP,
    NEITHER_ROOT_NOR_GROUPS,
    NOT_STOPPED,
    ROOT_STOPS,
    STOPPED,
    rows,
)

from catch_arena.descendants import LINUX
from catch_arena.tournament.isolation.control_groups import delegated_group

pytestmark = [
    pytest.mark.hostile,
    pytest.mark.skipif(not LINUX, reason="attackers look around as they can on Linux"),
]
_ROOT = os.geteuid() == 0
_GROUPS = delegated_group() is not None
SUCCEEDS = {
    STOPPED: False,
    NOT_STOPPED: True,
    AS_ROOT: None if _ROOT else False,
    ROOT_STOPS: None if _ROOT or _GROUPS else True,
    GROUPS_STOP: not _GROUPS,
    NEITHER_ROOT_NOR_GROUPS: None if _ROOT or _GROUPS else False,
    BY_LUCK: None,
    BY_SOME_KERNELS: None,
}
"""Whether an attack succeeds on this machine, by what the table says of it; None where it may or may not."""
PAGE = Path(__file__).parents[3] / "docs" / "attacks.md"


@pytest.fixture(scope="module")
def host():
    with Host() as started:
        yield started


@pytest.fixture(scope="module")
def outcome_of(host, tmp_path_factory):
    """What came of an attack; those that are tried together are tried once."""
    found = {}

    def outcome(attack, level):
        folder = tmp_path_factory.mktemp(level) / "world"
        if not attack.together:
            return host.attempt(attack, level, folder)
        if (attack.together, level) not in found:
            first, *others = [one for one in ATTACKS if one.together == attack.together]
            found[attack.together, level] = host.attempt(first, level, folder, also=others)
        return dataclasses.replace(found[attack.together, level], tried=attack.run.__name__)

    return outcome


def tried(level, attack):
    """Nightly where nothing has to hold: that what is not stopped is told truly."""
    holds = getattr(attack, level).startswith(STOPPED)
    return pytest.param(level, attack, id=f"{level}-{attack.name}", marks=() if holds else pytest.mark.nightly)


@pytest.mark.parametrize(("level", "attack"), [tried(level, attack) for level in LEVELS for attack in ATTACKS])
def test_it_is_stopped_where_the_table_says_so_and_nowhere_else(outcome_of, level, attack):
    outcome = outcome_of(attack, level)
    succeeds = SUCCEEDS[getattr(attack, level)]
    assert succeeds in {attack.succeeded(outcome), None}, outcome
    assert succeeds is not False or not outcome.broken, outcome


def test_the_page_has_the_table():
    _, _, *shown = [line for line in PAGE.read_text().splitlines() if line.startswith("|")]
    assert shown == rows()
