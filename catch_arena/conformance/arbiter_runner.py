"""Play of a case on an arbiter: unchanged, and in every variant that must not change the answer."""

import itertools
import random
from collections.abc import Callable, Iterator
from typing import Final

from msgspec.structs import replace

from catch_arena.conformance.adjudicator_calls import Difference, DiffersError
from catch_arena.conformance.cases import LOT, ArbiterCase, ExpectedRuling, Lot
from catch_arena.conformance.comparison import Compared, compare, decide_lots, request_rulings
from catch_arena.text import shortened
from catch_arena.verdicts import Verdict

Arbiter = Callable[..., object]
"""Function with the keyword arguments of `catch_arena.arbitrate`. It returns one ruling for each request, in order.

A ruling is an object with the attributes of a Ruling, a mapping with them as keys, or a sequence of them in their
order. A verdict may be a Verdict, its number or its name; a missing `distance_um` or `winner` means None."""

_MOST_VARIANTS: Final = 24
"""Number of orders, and of numberings, of one case that are played: all of up to four elements, a sample of more."""

Variants = Iterator[tuple[str, ArbiterCase]]
"""Pairs of a description of the change ("with the requests in the order ...") and the changed case."""


class ArbiterRunner:
    """Plays one case on an arbiter; a lot with a known seat must draw that seat."""

    def __init__(self, arbiter: Arbiter, case: ArbiterCase, compared: Compared) -> None:
        self._arbiter = arbiter
        self._case = case
        self._compared = compared
        self._wrong_evidence: tuple[str, list[Difference]] | None = None
        """The first variation in which only evidence is wrong: it must not hide a wrong verdict in a later one."""
        self.variation = ""
        """Description of the variant that is being played; "" for the unchanged case."""

    def run(self) -> None:
        """Play the case unchanged, and in every variant of it.

        Raise DiffersError at the first variant whose verdicts are wrong, else for the first whose evidence is.
        """
        case = self._case
        decided = _with_lots_decided(case, self._judge("", case))
        for variation, variant in (*_reordered(decided), *_without_loser(decided), *_renumbered(case)):
            self._judge(variation, variant)
        if case.fair_over_steps:
            self._require_fair_lots(case)
        if case.under_nearest:
            self._judge("under the policy nearest", replace(case, policy="nearest", expected=case.under_nearest))
        if self._wrong_evidence is not None:
            self.variation, differences = self._wrong_evidence
            raise DiffersError(*differences)

    def _judge(self, variation: str, case: ArbiterCase) -> tuple[ExpectedRuling, ...]:
        self.variation = variation
        arguments = case.arguments()
        given = request_rulings(lambda: self._arbiter(**arguments), case.expected)
        decided = decide_lots(given, case.expected, case.lots, case.kill_refused)
        differences = compare(given, decided, self._compared)
        if differences and all(difference.kind == "evidence" for difference in differences):
            self._wrong_evidence = self._wrong_evidence or (variation, differences)
            differences = compare(given, decided, "verdicts")
        if differences:
            raise DiffersError(*differences)
        return decided

    def _require_fair_lots(self, case: ArbiterCase) -> None:
        """Check that in `fair_over_steps` steps, with another seed in each, every seat wins some lots."""
        steps = f"over {case.fair_over_steps} steps, each with another seed"
        won: set[tuple[object, int | str | None]] = set()
        for later in range(case.fair_over_steps):
            variant = with_any_lots(replace(case, seed=case.seed + later, step=case.step + later))
            decided = self._judge(steps, variant)
            won |= {(ruling.target, ruling.winner) for ruling in decided}
            for variation, fewer in _without_loser(_with_lots_decided(variant, decided)):
                self._judge(f"{variation}, in one of many steps", fewer)
        for lot in case.lots:
            if never := [seat for seat in lot.seats if (lot.target, seat) not in won]:
                raise DiffersError(
                    Difference(
                        f"target {shortened(lot.target)}",
                        f"each of the hunters {', '.join(map(str, lot.seats))} wins in some of the steps",
                        f"never won by {' or '.join(f'hunter {seat}' for seat in never)}",
                        kind="winner",
                    )
                )


def with_any_lots(case: ArbiterCase) -> ArbiterCase:
    """Return the case with lots that may draw any one of their seats."""
    return replace(case, lots=tuple(replace(lot, drawn=None) for lot in case.lots))


def _with_lots_decided(case: ArbiterCase, decided: tuple[ExpectedRuling, ...]) -> ArbiterCase:
    """Return the case with its lots decided, as the basis of all further variants."""
    return replace(case, expected=decided, lots=())


def _reordered(case: ArbiterCase) -> Variants:
    """R5.1: yield variants with the requests in other orders.

    The requests of one hunter keep their order, because its first one counts.
    """
    for order in _orders(tuple(ruling.hunter for ruling in case.expected), case.id):
        places = ", ".join(str(place + 1) for place in order)
        yield (
            f"with the requests in the order {places}",
            replace(case, expected=tuple(case.expected[place] for place in order)),
        )


def _renumbered(case: ArbiterCase) -> Variants:
    """R5.1: yield variants with the hunters in other seats. A lot may then draw another hunter."""
    for order in _permutations(len(case.hunters), case.id):
        new = {old: seat for seat, old in enumerate(order)}

        def moved(ruling: ExpectedRuling, new: dict[int, int] = new) -> ExpectedRuling:
            winner = new[ruling.winner] if isinstance(ruling.winner, int) else ruling.winner
            return replace(ruling, hunter=new[ruling.hunter], winner=winner)

        yield (
            f"with the hunters in the seats {', '.join(str(new[old]) for old in range(len(order)))}",
            replace(
                case,
                hunters=tuple(case.hunters[old] for old in order),
                expected=tuple(map(moved, case.expected)),
                reach_m=case.reach_m if isinstance(case.reach_m, float) else tuple(case.reach_m[old] for old in order),
                inactive=tuple(sorted(new[old] for old in case.inactive)),
                teams=case.teams and tuple(tuple(new[old] for old in team) for team in case.teams),
                lots=tuple(
                    Lot(target=lot.target, seats=tuple(sorted(new[old] for old in lot.seats)), drawn=None)
                    for lot in case.lots
                ),
            ),
        )


def _without_loser(case: ArbiterCase) -> Variants:
    """R5.5: yield variants without the requests of one hunter that won nothing; the lots of the case are decided.

    No other ruling changes, with one exception: a refused kill without a rival is no longer a contest (R5.6). Losers
    that a catch may need (R5.10) stay.
    """
    for seat in sorted({ruling.hunter for ruling in case.expected}):
        if any(ruling.hunter == seat and _must_stay(ruling, case) for ruling in case.expected):
            continue
        rest = tuple(ruling for ruling in case.expected if ruling.hunter != seat)
        contested = {ruling.target for ruling in rest if ruling.verdict is Verdict.LOST_CONTEST}
        yield (
            f"without the requests of hunter {seat}",
            replace(
                case,
                expected=tuple(
                    replace(ruling, winner=None)
                    if ruling.verdict is Verdict.KILL_FAILED and ruling.target not in contested
                    else ruling
                    for ruling in rest
                ),
            ),
        )


def _must_stay(ruling: ExpectedRuling, case: ArbiterCase) -> bool:
    won = ruling.verdict in {Verdict.GRANTED, Verdict.KILL_FAILED, LOT}
    return won or (case.hunters_per_catch > 1 and ruling.verdict is Verdict.LOST_CONTEST)


def _permutations(count: int, name: str) -> list[tuple[int, ...]]:
    """Return all orders of `count` elements but the given one; for more than 4, a sample that depends on the name."""
    if count <= 4:
        return list(itertools.permutations(range(count)))[1:]
    source = random.Random(name)
    return [tuple(source.sample(range(count), count)) for _ in range(_MOST_VARIANTS)]


def _orders(seats: tuple[int, ...], name: str) -> list[tuple[int, ...]]:
    """Return orders of the requests, by their places, in which the requests of one seat keep their order."""
    given = tuple(range(len(seats)))
    found: dict[tuple[int, ...], None] = {}
    for order in _permutations(len(seats), name):
        waiting = {seat: iter([place for place, owner in enumerate(seats) if owner == seat]) for seat in seats}
        found[tuple(next(waiting[seats[place]]) for place in order)] = None
    return [order for order in found if order != given]
