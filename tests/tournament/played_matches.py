"""Made-up matches, for tests of statistics and tables."""

from typing import Any

from catch_arena.tournament.match import Forfeit, Match, MatchResult, PlayedMatch, ranks_of


def made_up(block: int, seating: tuple[int, ...], scores: tuple[int, ...], turn: int = 0, **parts: Any) -> PlayedMatch:
    """Return a match of a block, with these scores and other parts of its result; forfeits may be codes."""
    count = len(seating)
    usual = {
        "ranks": ranks_of(scores),
        "verdicts": ({},) * count,
        "contests_won": (0,) * count,
        "contests_lost": (0,) * count,
        "steps": 600,
        "digest": "ab",
        "thinking": (),
    }
    failed = parts.get("forfeits", ())
    parts["forfeits"] = tuple(Forfeit(one, 0, "") if isinstance(one, str) else one for one in failed) or (None,) * count
    match = Match(f"r00001-g{block + 1:06d}-s{turn:02d}", block, 7 + block, seating)
    return PlayedMatch(match, MatchResult(scores, **(usual | parts)))
