"""Which recorded matches stand in the page itself, where there is no room for all."""

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import NamedTuple

from catch_arena.errors import ReplayError
from catch_arena.player import film_text
from catch_arena.report.findings import Findings
from catch_arena.tournament.match import Played


class Chosen(NamedTuple):
    """A match that the page plays."""

    film: str
    why: str


def chosen(findings: Findings, budget: int, asked: Sequence[str] = ()) -> dict[str, Chosen]:
    """Films by match, until they take `budget` bytes; those that were `asked` for come first, and always.

    Raises: ReplayError where one that was asked for was not recorded.
    """
    films = {match: Chosen(film_text(findings.replay(match)), "asked for") for match in asked}
    taken = sum(len(film.film) for film in films.values())
    for match, why in _by_interest(findings):
        if match in films:
            continue
        try:
            film = film_text(findings.replay(match))
        except ReplayError:  # it was moved away, or its ruleset is another: the figures do without
            continue
        taken += len(film)
        if taken > budget:
            break
        films[match] = Chosen(film, why)
    return films


def _by_interest(findings: Findings) -> Iterator[tuple[str, str]]:
    """Each recorded match once: in turn one with many contests, a close one, one that the best lost, a forfeit."""
    recorded = [one for one in findings.played if one.match.id in findings.recorded]
    best = findings.names.index(findings.standings[0].name)
    lost = [one for one in recorded if _lost_by(one, best)]
    orders = {
        "contests": sorted(recorded, key=_contests, reverse=True),
        "close": sorted(recorded, key=_margin),
        f"{findings.names[best]} loses": sorted(lost, key=_margin, reverse=True),
        "forfeit": [one for one in recorded if any(one.result.forfeits)],
    }
    seen = set()
    for row in zip_longest(*orders.values()):
        for why, one in zip(orders, row, strict=True):
            if one is not None and one.match.id not in seen:
                seen.add(one.match.id)
                yield one.match.id, why


def _margin(one: Played) -> int:
    """How far the first is ahead of the second."""
    first, second, *_ = (*sorted(one.result.scores, reverse=True), 0)
    return first - second


def _contests(one: Played) -> int:
    return sum(tally.get("LOST_CONTEST", 0) for tally in one.result.verdicts)


def _lost_by(one: Played, place: int) -> bool:
    return any(who == place and rank > 1 for who, rank in zip(one.match.seating, one.result.ranks, strict=True))
