"""Playing a case on an arbiter: as it stands, and in every arrangement that must not change the answer."""

import copy
from collections.abc import Callable

from catch_arena.conformance import arrangements
from catch_arena.conformance.answers import DiffersError, shown
from catch_arena.conformance.cases import ArbiterCase, Asked
from catch_arena.conformance.comparison import Call, OtherLot, Strictness, compare, rulings

Arbiter = Callable[..., object]
"""Takes the keyword arguments of `catch_arena.arbitrate`, and returns one ruling for each request, in their order: each
an object with the attributes of a Ruling, a mapping with them as keys, or a sequence of them in their order. A verdict
may be a Verdict, its number or its name; what has no `distance_um` or `winner` has None."""


class Court:
    """One arbiter on trial with one case."""

    def __init__(self, arbiter: Arbiter, strictness: Strictness) -> None:
        self._arbiter = arbiter
        self._strictness = strictness
        self.how = ""
        """How the requests were arranged that are being judged; "" as the case has them."""
        self.calls: list[Call] = []
        """What it has answered so far."""

    def try_case(self, case: ArbiterCase) -> None:
        """Raises: DiffersError, at the first arrangement whose answer is wrong."""
        decided = arrangements.settled(case, self._judge("", case))
        for told_otherwise in (
            arrangements.reordered(decided),
            arrangements.without_a_loser(decided),
            arrangements.renumbered(case),
        ):
            for how, arranged in told_otherwise:
                self._judge(how, arranged)
        if case.fair_over_steps:
            self._require_fair_lots(case)
        if case.standard:
            self._judge("under the policy nearest", arrangements.under_the_standard_policy(case))

    def _judge(self, how: str, case: ArbiterCase) -> tuple[Asked, ...]:
        self.how = how
        arguments = copy.deepcopy(case.arguments())  # a stranger may change what it is given
        given = rulings(lambda: self._arbiter(**arguments), case.asked)
        self.calls.append(Call(case.arguments(), given))
        return compare(
            given,
            case.asked,
            lots=case.lots,
            refused=case.circumstances["kill_refused"],
            strictness=self._strictness,
        )

    def _require_fair_lots(self, case: ArbiterCase) -> None:
        steps = f"over {case.fair_over_steps} steps, each with another seed"
        won: set[tuple[object, int | str | None]] = set()
        for arranged in arrangements.in_other_steps(case):
            decided = self._judge(steps, arranged)
            won |= {(one.name, one.winner) for one in decided}
            for how, fewer in arrangements.without_a_loser(arrangements.settled(arranged, decided)):
                self._judge(f"{how}, in one of many steps", fewer)
        for lot in case.lots:
            if never := [seat for seat in lot.seats if (lot.target, seat) not in won]:
                raise DiffersError(
                    OtherLot(
                        f"target {shown(lot.target)}",
                        f"each of the hunters {', '.join(map(str, lot.seats))} wins in some of the steps",
                        f"never won by {' or '.join(f'hunter {seat}' for seat in never)}",
                    )
                )
