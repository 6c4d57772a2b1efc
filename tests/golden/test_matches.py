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
