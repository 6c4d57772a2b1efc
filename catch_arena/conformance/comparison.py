"""An adjudicator's answer beside what a case expects of it."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from catch_arena.conformance.answers import (
    Difference,
    DiffersError,
    OtherTarget,
    answered,
    read_rulings,
    request,
    shown,
)
from catch_arena.conformance.cases import ANY, LOT, Asked, Lot
from catch_arena.verdicts import Verdict


@dataclass(frozen=True, slots=True, kw_only=True)
class Strictness:
    """What is compared."""

    evidence: bool = True
    """Distances and winners too, not the verdicts alone."""
    exact_lots: bool = False
    """A lot must draw the seat that the appendix's hash draws; else any one of its seats will do."""


@dataclass(frozen=True, slots=True)
class OtherRuling(Difference):
    """A ruling that is not the expected one."""

    right: Asked
    """Its lot is decided."""
    given: Asked


@dataclass(frozen=True, slots=True)
class OtherLot(Difference):
    """A lot that does not give a target to one of the tied, or never to some of them."""


@dataclass(frozen=True, slots=True)
class Call:
    """What an adjudicator was asked and what it answered, where that could be read."""

    arguments: Mapping[str, Any]
    """Those of `catch_arena.arbitrate`."""
    answered: tuple[Asked, ...]


def rulings(call: Callable[[], object], asked: Sequence[Asked]) -> tuple[Asked, ...]:
    """What an adjudicator answers. Raises: DiffersError where that cannot be read."""
    given = answered("the call", call)
    return tuple(answered("the answer", read_rulings, given, asked))


def compare(
    given: Sequence[Asked],
    asked: Sequence[Asked],
    *,
    lots: Sequence[Lot],
    refused: Iterable[object],
    strictness: Strictness,
) -> tuple[Asked, ...]:
    """The expected rulings, with the lots as the adjudicator drew them, where its answer agrees with them.

    Args: `given`, its rulings; `asked`, with what is expected; `refused`, the targets whose kill is refused.
    Raises: DiffersError, with every difference that can be told.
    """
    by_lot = {one.name for one in asked if one.verdict == LOT}
    winners = {lot.target: _winner(lot, asked, given, strictness) for lot in lots if lot.target in by_lot}
    expected = _settled(asked, winners, set(refused))
    differences = [
        OtherRuling(
            request(place, one), _describe(one, one, strictness), _describe(one, ruling, strictness), one, ruling
        )
        for place, (one, ruling) in enumerate(zip(expected, given, strict=True), start=1)
        if compared(one, one, strictness) != compared(one, ruling, strictness)
    ]
    if differences:
        raise DiffersError(*differences)
    return expected


def _winner(lot: Lot, asked: Sequence[Asked], rulings: Sequence[Asked], strictness: Strictness) -> int:
    """Whom a lot drew: the one seat that the rulings let win."""
    tied = [
        (one, ruling)
        for one, ruling in zip(asked, rulings, strict=True)
        if one.verdict == LOT and one.name == lot.target
    ]
    won = [one.hunter for one, ruling in tied if ruling.verdict in {Verdict.GRANTED, Verdict.KILL_FAILED}]
    allowed = (lot.drawn,) if strictness.exact_lots and lot.drawn is not None else lot.seats
    if len(won) != 1 or won[0] not in allowed:
        raise DiffersError(
            OtherLot(
                f"target {shown(lot.target)}",
                f"exactly one winner, drawn by lot: hunter {' or '.join(map(str, allowed))}",
                f"won by {' and '.join(f'hunter {seat}' for seat in won) or 'nobody'}",
            )
        )
    return won[0]


def _settled(asked: Sequence[Asked], winners: Mapping[object, int], refused: set[object]) -> tuple[Asked, ...]:
    """The rulings that follow once it is known whom the lots drew."""
    settled = []
    for one in asked:
        verdict, winner = one.verdict, one.winner
        if winner == LOT:
            winner = winners[one.name]
        if verdict == LOT:
            won = Verdict.KILL_FAILED if one.name in refused else Verdict.GRANTED
            verdict = won if one.hunter == winner else Verdict.LOST_CONTEST
        settled.append(replace(one, verdict=verdict, winner=winner))
    return tuple(settled)


def compared(expected: Asked, one: Asked, strictness: Strictness) -> Asked:
    """What of a ruling is compared."""
    if not strictness.evidence:
        return replace(one, distance_um=None, winner=None)
    if expected.distance_um == ANY and one.distance_um is not None:
        return replace(one, distance_um=ANY)
    return one


def _describe(expected: Asked, one: Asked, strictness: Strictness) -> str:
    """What of a ruling is compared, in words; its lot is decided."""
    one = compared(expected, one, strictness)
    words = [one.verdict.name if isinstance(one.verdict, Verdict) else one.verdict]
    if one.distance_um is not None:
        words.append("some distance away" if one.distance_um == ANY else f"{one.distance_um} um away")
    if one.winner is not None:
        words.append(f"won by hunter {one.winner}")
    if one.hunter != expected.hunter:
        words.append(f"for hunter {one.hunter}")
    if isinstance(one.name, OtherTarget):
        words.append(f"for target {one.name.shown}")
    return ", ".join(words)
