"""Comparison of an adjudicator's answer with the answer that a case expects."""

from collections.abc import Callable, Collection, Sequence
from typing import Literal, TypeAlias

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

Compared: TypeAlias = Literal["evidence", "verdicts", "success"]
"""Parts of an answer that are compared: all; the verdicts, without distances and winners; or only if requests are
granted, since the service catch_turtle answers no more than that.
"""


def request_rulings(function: Callable[[], object], expected: Sequence[ExpectedRuling]) -> tuple[Ruling, ...]:
    """Call an adjudicator, and return its rulings."""
    given = call_adjudicator("the call", function)
    return tuple(call_adjudicator("the answer", read_rulings, given, expected))


def compare(given: Sequence[Ruling], expected: Sequence[ExpectedRuling], compared: Compared) -> list[Difference]:
    """Return the differences of rulings from the expected ones, whose lots are decided."""
    differences = []
    for place, (right, ruling) in enumerate(zip(expected, given, strict=True), start=1):
        wanted, got = _describe(right, right, compared), _describe(right, ruling, compared)
        if wanted != got:
            differences.append(Difference(describe_request(place, right), wanted, got, kind=_kind(right, ruling)))
    return differences


def decide_lots(
    given: Sequence[Ruling], expected: Sequence[ExpectedRuling], lots: Sequence[Lot], refused: Collection[object]
) -> tuple[ExpectedRuling, ...]:
    """Return the expected rulings with the lots as the adjudicator drew them: each needs exactly one allowed winner.

    The kill of the targets in `refused` is refused.
    """
    by_lot = {ruling.target for ruling in expected if ruling.verdict == LOT}
    winners = {lot.target: _winner(lot, expected, given) for lot in lots if lot.target in by_lot}
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


def _winner(lot: Lot, expected: Sequence[ExpectedRuling], given: Sequence[Ruling]) -> int:
    """Return the seat that a lot drew: the only one that wins by the rulings, and one that may win."""
    won = [
        wanted.hunter
        for wanted, ruling in zip(expected, given, strict=True)
        if wanted.verdict == LOT
        and wanted.target == lot.target
        and ruling.verdict in {Verdict.GRANTED, Verdict.KILL_FAILED}
    ]
    allowed = lot.seats if lot.drawn is None else (lot.drawn,)
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


def _kind(right: ExpectedRuling, given: Ruling) -> str:
    """Return the kind of a difference: see KINDS."""
    if (right.verdict is Verdict.GRANTED) != given.success:
        return "granted" if given.success else "refused"
    return "evidence" if right.verdict is given.verdict else "verdict"


def _describe(right: ExpectedRuling, ruling: ExpectedRuling | Ruling, compared: Compared) -> str:
    """Return the compared parts of a ruling in words: rulings with the same words are equal."""
    verdict = ruling.verdict.name if isinstance(ruling.verdict, Verdict) else ruling.verdict
    if compared == "success" and verdict != Verdict.GRANTED.name:
        verdict = "refused"
    words = [verdict]
    if compared == "evidence" and ruling.distance_um is not None:
        words.append("at any distance" if right.distance_um == ANY else f"{ruling.distance_um} um away")
    if compared == "evidence" and ruling.winner is not None:
        words.append(f"won by hunter {ruling.winner}")
    if ruling.hunter != right.hunter:
        words.append(f"for hunter {ruling.hunter}")
    if isinstance(ruling.target, WrongTarget):
        words.append(f"for target {ruling.target.shortened}")
    return ", ".join(words)
