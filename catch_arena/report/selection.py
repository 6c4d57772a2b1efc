"""Selection of the recorded matches that the page itself holds, since it has no room for all."""

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import NamedTuple

from catch_arena.errors import ReplayError
from catch_arena.explanation import Explanation, explain
from catch_arena.player.bundle import bundle_text
from catch_arena.report.data import ReportData
from catch_arena.tournament.match import PlayedMatch


class SelectedMatch(NamedTuple):
    """Match that the page plays: its replay bundle, the reason for the choice, and its explanation."""

    bundle: str
    why: str
    explanation: Explanation


def select_matches(data: ReportData, budget: int, requested: Sequence[str] = ()) -> dict[str, SelectedMatch]:
    """Return matches by their ids, until their bundles take `budget` bytes; `requested` matches come first, and always.

    Raises ReplayError if a requested match was not recorded.
    """
    selected: dict[str, SelectedMatch] = {}
    taken = 0
    for match, why in [*((match, "requested") for match in requested), *_by_interest(data)]:
        if match in selected:
            continue
        try:
            replay = data.replay(match)
            choice = SelectedMatch(bundle_text(replay), why, explain(replay))
        except ReplayError:  # it was moved away or has another ruleset; the figures do not need it
            if match in requested:
                raise
            continue
        taken += len(choice.bundle)
        if taken > budget and match not in requested:
            break
        selected[match] = choice
    return selected


def _by_interest(data: ReportData) -> Iterator[tuple[str, str]]:
    """Yield each recorded match once: by turns one with many contests, a close one, a loss of the best, a forfeit."""
    recorded = [played_match for played_match in data.played if played_match.match.id in data.recorded]
    best, hunting = data.names.index(data.standings[0].name), data.parties.hunting
    lost = [played_match for played_match in recorded if _lost_by(played_match, best, hunting)]
    orders = {
        "contests": sorted(recorded, key=lambda played_match: sum(played_match.result.contests_lost), reverse=True),
        "close": sorted(recorded, key=lambda played_match: _margin(played_match, hunting)),
        f"{data.names[best]} loses": sorted(
            lost, key=lambda played_match: _margin(played_match, hunting), reverse=True
        ),
        "forfeit": [played_match for played_match in recorded if any(played_match.result.forfeits)],
    }
    seen = set()
    for turn in zip_longest(*orders.values()):
        for why, played_match in zip(orders, turn, strict=True):
            if played_match is not None and played_match.match.id not in seen:
                seen.add(played_match.match.id)
                yield played_match.match.id, why


def _margin(played_match: PlayedMatch, hunting: int) -> int:
    """Return the difference between the best two scores of the hunting parties."""
    first, second, *_ = (*sorted(played_match.result.scores[:hunting], reverse=True), 0)
    return first - second


def _lost_by(played_match: PlayedMatch, entrant: int, hunting: int) -> bool:
    hunters = zip(played_match.match.seating[:hunting], played_match.result.ranks[:hunting], strict=True)
    return any(player == entrant and rank > 1 for player, rank in hunters)
