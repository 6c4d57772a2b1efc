"""The same case told otherwise: requests in other orders, hunters renumbered, a loser left out.

R5.1 and R5.5 say that none of this may change an answer, so every case is played in these forms too.
"""

import itertools
import random
from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from catch_arena.conformance.cases import LOT, ArbiterCase, Asked, Lot
from catch_arena.verdicts import Verdict

_MOST: Final = 24
"""How many orders and how many numberings of one case are played: all those of four, a sample of more."""


def settled(case: ArbiterCase, asked: tuple[Asked, ...]) -> ArbiterCase:
    """The case with its lots decided: what it expects of every further arrangement."""
    return replace(case, asked=asked, lots=())


def reordered(case: ArbiterCase) -> Iterator[tuple[str, ArbiterCase]]:
    """R5.1: the requests in other orders; those of one hunter keep theirs, since its first one stands.

    Yields: how it was arranged, and the case in that form.
    """
    for order in _orders(tuple(one.hunter for one in case.asked), case.id):
        told = ", ".join(str(place + 1) for place in order)
        yield (
            f"with the requests in the order {told}",
            replace(case, asked=tuple(case.asked[place] for place in order)),
        )


def renumbered(case: ArbiterCase) -> Iterator[tuple[str, ArbiterCase]]:
    """R5.1: the hunters in other seats. A lot may then draw another one.

    Yields: how it was arranged, and the case in that form.
    """
    for order in _permutations(len(case.hunters), case.id):
        new = {old: seat for seat, old in enumerate(order)}

        def moved(one: Asked, new: dict[int, int] = new) -> Asked:
            winner = new[one.winner] if isinstance(one.winner, int) else one.winner
            return replace(one, hunter=new[one.hunter], winner=winner)

        yield (
            f"with the hunters in the seats {', '.join(str(new[old]) for old in range(len(order)))}",
            replace(
                case,
                hunters=tuple(case.hunters[old] for old in order),
                asked=tuple(map(moved, case.asked)),
                circumstances={
                    **case.circumstances,
                    "inactive": tuple(sorted(new[old] for old in case.circumstances["inactive"])),
                },
                lots=tuple(
                    Lot(target=lot.target, seats=tuple(sorted(new[old] for old in lot.seats)), drawn=None)
                    for lot in case.lots
                ),
            ),
        )


def without_a_loser(case: ArbiterCase) -> Iterator[tuple[str, ArbiterCase]]:
    """R5.5: what a hunter asked that won nothing is left out; nobody else's ruling changes, but that a refused kill
    without a rival is no contest any more (R5.6).

    Args: `case`, with its lots decided.
    Yields: how it was arranged, and the case in that form.
    """
    for seat in sorted({one.hunter for one in case.asked}):
        if any(one.hunter == seat and _has_won(one) for one in case.asked):
            continue
        rest = tuple(one for one in case.asked if one.hunter != seat)
        contested = {one.name for one in rest if one.verdict is Verdict.LOST_CONTEST}
        yield (
            f"without what hunter {seat} asked",
            replace(
                case,
                asked=tuple(
                    replace(one, winner=None)
                    if one.verdict is Verdict.KILL_FAILED and one.name not in contested
                    else one
                    for one in rest
                ),
            ),
        )


def in_other_steps(case: ArbiterCase) -> Iterator[ArbiterCase]:
    """The case in `fair_over_steps` steps, with another seed in each."""
    lots = tuple(replace(lot, drawn=None) for lot in case.lots)
    seed, step = case.circumstances["seed"], case.circumstances["step"]
    for later in range(case.fair_over_steps):
        circumstances = {**case.circumstances, "seed": seed + later, "step": step + later}
        yield replace(case, circumstances=circumstances, lots=lots)


def under_the_standard_policy(case: ArbiterCase) -> ArbiterCase:
    """The same requests under `nearest`, with what that answers."""
    circumstances = {**case.circumstances, "policy": "nearest"}
    return replace(case, circumstances=circumstances, asked=case.standard, standard=())


def _has_won(asked: Asked) -> bool:
    return asked.verdict in {Verdict.GRANTED, Verdict.KILL_FAILED, LOT}


def _permutations(count: int, name: str) -> list[tuple[int, ...]]:
    """All orders of that many things but the given one, or a sample of them that depends on the name alone."""
    if count <= 4:
        return list(itertools.permutations(range(count)))[1:]
    source = random.Random(name)
    return [tuple(source.sample(range(count), count)) for _ in range(_MOST)]


def _orders(seats: tuple[int, ...], name: str) -> list[tuple[int, ...]]:
    """Orders of requests, by their places, in which those of one seat keep theirs."""
    given = tuple(range(len(seats)))
    found = dict.fromkeys(_in_turn(seats, order) for order in _permutations(len(seats), name))
    return [order for order in found if order != given]


def _in_turn(seats: tuple[int, ...], order: tuple[int, ...]) -> tuple[int, ...]:
    """The order, with the places of each seat sorted."""
    waiting = {seat: iter([place for place, one in enumerate(seats) if one == seat]) for seat in set(seats)}
    return tuple(next(waiting[seats[place]]) for place in order)
