"""Golden matches are replayed line by line, by every adjudicator (`make golden`)."""

from itertools import zip_longest

import pytest
from golden.matches import Match, matches
from rulebook.adjudicators import ADJUDICATORS

MATCHES = matches()


@pytest.mark.parametrize("kind", ADJUDICATORS)
@pytest.mark.parametrize("match", MATCHES, ids=lambda match: match.path.stem)
def test_a_golden_match_is_played_as_it_was(match: Match, kind: str) -> None:
    """Every step's poses and digest, every verdict, and who comes and goes."""
    kept = match.path.read_text(encoding="utf-8").splitlines()
    for number, (expected, played) in enumerate(zip_longest(kept, match.lines(kind)), start=1):
        if played != expected:
            where = f"{match.path.name}, line {number}, played by the {kind}"
            pytest.fail(f"{where}\nexpected: {expected}\nplayed:   {played}", pytrace=False)


def test_the_golden_matches_have_all_controls_policies_ends_and_what_can_happen_in_an_arena() -> None:
    """So that a rule that plays otherwise shows in one of them."""
    texts = " ".join(match.path.read_text(encoding="utf-8") for match in MATCHES)
    verdicts = {
        "GRANTED",
        "LOST_CONTEST",
        "OUT_OF_REACH",
        "SERVICE_DOWN",
        "KILL_FAILED",
        "MALFORMED",
        "HUNTER_INACTIVE",
    }
    for word in (*(f": {verdict}" for verdict in verdicts), "leaves", "appears", "withdraw", "terminated", "truncated"):
        assert word in texts
    assert {control for match in MATCHES for control in match.config.controls} == {"target", "velocity", "full"}
    assert {match.config.policy for match in MATCHES} == {"nearest", "first_come", "capstone"}
    assert {match.config.target_motion for match in MATCHES} >= {"still", "flee"}
    assert any(match.config.partial_view and match.config.view_noise_m > 0 for match in MATCHES)
