"""Comparison of an adjudicator's answer with the answer that a case expects."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from msgspec.structs import replace

from catch_arena.conformance.adjudicator_calls import (
    Difference,
    DiffersError,
    WrongTarget,
    call_adjudicator,
    describe_request,
    read_rulings,
)
from catch_arena.conformance.cases import ANY, LOT, ExpectedRuling, Lot
from catch_arena.text import shortened
from catch_arena.verdicts import Ruling, Verdict


@dataclass(frozen=True, slots=True, kw_only=True)
class Strictness:
    """Parts of an answer that are compared."""

    evidence: bool = True
    """True to compare distances and winners, not the verdicts alone."""
    exact_lots: bool = False
    """True if a lot must draw the seat that the appendix's hash draws; else any one of its seats may win."""
    success_only: bool = False
    """True to compare only if requests are granted: the service catch_turtle answers no more than that."""


REFUSED: Final = Verdict.OUT_OF_REACH
"""Verdict that stands for every refusal if an answer contains only the success."""


def request_rulings(function: Callable[[], object], expected: Sequence[ExpectedRuling]) -> tuple[Ruling, ...]:
    """Call an adjudicator and return its rulings.

    Raises:
        DiffersError: if its answer cannot be read.
    """
    given = call_adjudicator("the call", function)
    return tuple(call_adjudicator("the answer", read_rulings, given, expected))


def compare(
    given: Sequence[Ruling],
    expected: Sequence[ExpectedRuling],
    *,
    lots: Sequence[Lot],
    refused: Iterable[object],
    strictness: Strictness,
) -> tuple[ExpectedRuling, ...]:
    """Compare rulings with the expected ones, and return the expected ones with the lots as the adjudicator drew them.

    Args:
        given: the adjudicator's rulings.
        expected: the rulebook's rulings.
        lots: the lots that may be drawn.
        refused: the targets whose kill is refused.
        strictness: the parts of an answer that are compared.

    Raises:
        DiffersError: for a lot without exactly one allowed winner, else with all differences.
    """
    by_lot = {ruling.target for ruling in expected if ruling.verdict == LOT}
    winners = {lot.target: _winner(lot, expected, given, strictness) for lot in lots if lot.target in by_lot}
    decided = _decide_lots(expected, winners, set(refused))
    differences = [
        Difference(
            describe_request(place, right),
            _describe(right, right, strictness),
            _describe(right, ruling, strictness),
            kind=_kind(right, ruling),
        )
        for place, (right, ruling) in enumerate(zip(decided, given, strict=True), start=1)
        if _compared(right, right, strictness) != _compared(right, ruling, strictness)
    ]
    if differences:
        raise DiffersError(*differences)
    return decided


def _winner(lot: Lot, expected: Sequence[ExpectedRuling], given: Sequence[Ruling], strictness: Strictness) -> int:
    """Return the seat that a lot drew: the only one that wins by the rulings.

    Raises:
        DiffersError: if not exactly one seat wins, or if that seat may not win.
    """
    won = [
        wanted.hunter
        for wanted, ruling in zip(expected, given, strict=True)
        if wanted.verdict == LOT
        and wanted.target == lot.target
        and ruling.verdict in {Verdict.GRANTED, Verdict.KILL_FAILED}
    ]
    allowed = (lot.drawn,) if strictness.exact_lots and lot.drawn is not None else lot.seats
    if len(won) != 1 or won[0] not in allowed:
        raise DiffersError(
            Difference(
                f"target {shortened(lot.target)}",
                f"exactly one winner, drawn by lot: hunter {' or '.join(map(str, allowed))}",
                f"won by {' and '.join(f'hunter {seat}' for seat in won) or 'no hunter'}",
                kind="refused" if not won else "winner" if len(won) == 1 else "granted",
            )
        )
    return won[0]


def _decide_lots(
    expected: Sequence[ExpectedRuling], winners: Mapping[object, int], refused: set[object]
) -> tuple[ExpectedRuling, ...]:
    """Return the expected rulings with the verdicts and winners that follow from the drawn seats."""
    decided = []
    for ruling in expected:
        answer, winner = ruling.answer, ruling.winner
        if winner == LOT:
            winner = winners[ruling.target]
        if answer == LOT:
            won = Verdict.KILL_FAILED if ruling.target in refused else Verdict.GRANTED
            answer = (won if ruling.hunter == winner else Verdict.LOST_CONTEST).name
        decided.append(replace(ruling, answer=answer, winner=winner))
    return tuple(decided)


def _kind(right: ExpectedRuling, given: Ruling) -> str:
    """Return the kind of a difference: see KINDS."""
    if (right.verdict is Verdict.GRANTED) != given.success:
        return "granted" if given.success else "refused"
    return "evidence" if right.verdict is given.verdict else "verdict"


class _Compared(NamedTuple):
    """The fields of a ruling that are compared; in a tuple a NaN is equal to itself."""

    hunter: int
    target: object
    verdict: Verdict | str
    distance_um: int | str | None
    winner: int | str | None


def _compared(right: ExpectedRuling, ruling: ExpectedRuling | Ruling, strictness: Strictness) -> _Compared:
    if strictness.success_only:
        granted = Verdict.GRANTED.name if ruling.verdict is Verdict.GRANTED else "refused"
        return _Compared(ruling.hunter, ruling.target, granted, None, None)
    if not strictness.evidence:
        return _Compared(ruling.hunter, ruling.target, ruling.verdict, None, None)
    distance_um = ANY if right.distance_um == ANY and ruling.distance_um is not None else ruling.distance_um
    return _Compared(ruling.hunter, ruling.target, ruling.verdict, distance_um, ruling.winner)


def _describe(right: ExpectedRuling, ruling: ExpectedRuling | Ruling, strictness: Strictness) -> str:
    """Return the compared fields of a ruling in words; its lot is decided."""
    hunter, target, verdict, distance_um, winner = _compared(right, ruling, strictness)
    words = [verdict.name if isinstance(verdict, Verdict) else verdict]
    if distance_um is not None:
        words.append("at any distance" if distance_um == ANY else f"{distance_um} um away")
    if winner is not None:
        words.append(f"won by hunter {winner}")
    if hunter != right.hunter:
        words.append(f"for hunter {hunter}")
    if isinstance(target, WrongTarget):
        words.append(f"for target {target.shortened}")
    return ", ".join(words)
