"""Selection of the recorded matches that the page itself holds, since it has no room for all."""

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import NamedTuple

from catch_arena.errors import ReplayError
from catch_arena.player import bundle_text
from catch_arena.report.data import ReportData
from catch_arena.tournament.match import PlayedMatch


class SelectedMatch(NamedTuple):
    """Match that the page plays: its replay bundle, and the reason for the choice."""

    bundle: str
    why: str


def select_matches(data: ReportData, budget: int, asked: Sequence[str] = ()) -> dict[str, SelectedMatch]:
    """Return matches by their ids, until their bundles take `budget` bytes; `asked` matches come first, and always.

    Raises:
        ReplayError: if a match that was asked for was not recorded.
    """
    selected = {match: SelectedMatch(bundle_text(data.replay(match)), "requested") for match in asked}
    taken = sum(len(one.bundle) for one in selected.values())
    for match, why in _by_interest(data):
        if match in selected:
            continue
        try:
            bundle = bundle_text(data.replay(match))
        except ReplayError:  # it was moved away or has another ruleset; the figures do not need it
            continue
        taken += len(bundle)
        if taken > budget:
            break
        selected[match] = SelectedMatch(bundle, why)
    return selected


def _by_interest(data: ReportData) -> Iterator[tuple[str, str]]:
    """Yield each recorded match once: by turns one with many contests, a close one, a loss of the best, a forfeit."""
    recorded = [one for one in data.played if one.match.id in data.recorded]
    best, hunting = data.names.index(data.standings[0].name), data.parties.hunting
    lost = [one for one in recorded if _lost_by(one, best, hunting)]
    orders = {
        "contests": sorted(recorded, key=lambda one: sum(one.result.contests_lost), reverse=True),
        "close": sorted(recorded, key=lambda one: _margin(one, hunting)),
        f"{data.names[best]} loses": sorted(lost, key=lambda one: _margin(one, hunting), reverse=True),
        "forfeit": [one for one in recorded if any(one.result.forfeits)],
    }
    seen = set()
    for turn in zip_longest(*orders.values()):
        for why, one in zip(orders, turn, strict=True):
            if one is not None and one.match.id not in seen:
                seen.add(one.match.id)
                yield one.match.id, why


def _margin(one: PlayedMatch, hunting: int) -> int:
    """Return the difference between the best two scores of the hunting parties."""
    first, second, *_ = (*sorted(one.result.scores[:hunting], reverse=True), 0)
    return first - second


def _lost_by(one: PlayedMatch, entrant: int, hunting: int) -> bool:
    hunters = zip(one.match.seating[:hunting], one.result.ranks[:hunting], strict=True)
    return any(who == entrant and rank > 1 for who, rank in hunters)
