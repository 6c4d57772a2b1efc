"""Which of the known mistakes an adjudicator has, by what it answered."""

import operator
from collections.abc import Iterable, Sequence
from typing import Final

from catch_arena.conformance.answers import OtherTarget, shown
from catch_arena.conformance.cases import Asked
from catch_arena.conformance.comparison import Call, OtherLot, OtherRuling, Strictness
from catch_arena.conformance.mistakes import KNOWN, Mistake, bent, mistaken_verdicts
from catch_arena.conformance.results import Result
from catch_arena.conformance.rules import Claim, Lottery, Rules, judge

_FIRST: Final[Lottery] = operator.itemgetter(0)
_LAST: Final[Lottery] = operator.itemgetter(-1)


class Search:
    """The known mistakes that together answer as an adjudicator does in the most cases.

    A failure is explained by rules that give its very answers, in every arrangement that was played until it failed.
    """

    def __init__(self, results: Sequence[Result], strictness: Strictness) -> None:
        self._evidence = strictness.evidence
        self._passed = [result for result in results if result.failure is None and result.calls]
        self._failed = [result for result in results if _is_judged(result)]
        self._lawful = {
            result.case.id for result in self._failed if all(self._gives(Rules(), call) for call in result.calls)
        }
        self._helps: dict[tuple[str, object, str], bool] = {}

    def is_lawful(self, result: Result) -> bool:
        """Whether each answer to a failed case could have been right alone: its lots do not go together."""
        return result.case.id in self._lawful

    def mistakes(self) -> list[Mistake]:
        """One after the other, each time the one with which the most failures are explained, less the passes that it
        would have failed.
        """
        seen = {
            (one.right.verdict, one.given.verdict): None
            for result in self._failed
            for one in (result.failure.differences if result.failure else ())
            if isinstance(one, OtherRuling)
        }
        candidates = [*KNOWN, *mistaken_verdicts(seen)]
        found: list[Mistake] = []
        score = 0
        while True:
            better = self._next(found, candidates, score)
            if better is None:  # one mistake can hide what another one does
                self._helps.clear()
                better = self._next(found, candidates, score)
            if better is None:
                return found
            found, score = better

    def _next(
        self, found: Sequence[Mistake], candidates: Iterable[Mistake], score: int
    ) -> tuple[list[Mistake], int] | None:
        """One mistake more and the score with it, where there is a better one."""
        explained, best = self._explained(found), None
        for one, helped in self._helped_by(found, (one for one in candidates if one not in found)):
            if not helped or explained + helped <= score:
                break
            tried = [*found, one]
            now = self._explained(tried) - self._contradicted(tried)
            if now > score:
                best, score = (tried, now), now
        return best

    def culprits(self, found: Sequence[Mistake], result: Result) -> list[Mistake]:
        """As few of the mistakes found as explain a failure; none where they do not."""
        if not _is_judged(result) or not self._explains(bent(found), result):
            return []
        for one in found:
            if self._explains(bent([one]), result):
                return [one]
        needed = list(found)
        for one in found:
            fewer = [other for other in needed if other is not one]
            if self._explains(bent(fewer), result):
                needed = fewer
        return needed

    def _helped_by(self, found: Sequence[Mistake], candidates: Iterable[Mistake]) -> list[tuple[Mistake, int]]:
        """About how many more failures each of the candidates explains, most first.

        That is worked out once for each answer that the mistakes found so far lead to: they seldom matter otherwise.
        """
        base = bent(found)
        left = [(result, self._answer(base, result)) for result in self._failed if not self._explains(base, result)]
        helped = []
        for one in candidates:
            rules = bent([*found, one])
            count = 0
            for result, so_far in left:
                key = (result.case.id, so_far, one.looks_like)
                if key not in self._helps:
                    self._helps[key] = self._explains(rules, result)
                count += self._helps[key]
            helped.append((one, count))
        return sorted(helped, key=lambda pair: -pair[1])

    def _explained(self, mistakes: Sequence[Mistake]) -> int:
        rules = bent(mistakes)
        return sum(self._explains(rules, result) for result in self._failed)

    def _contradicted(self, mistakes: Sequence[Mistake]) -> int:
        """How many cases were passed that these mistakes would have failed."""
        rules = bent(mistakes)
        return sum(not self._gives(rules, result.calls[0]) for result in self._passed)

    def _explains(self, rules: Rules, result: Result) -> bool:
        # where only the lots are at fault, the rules must draw so by themselves
        lots = (_FIRST, _LAST) if self.is_lawful(result) else (None,)
        return all(self._gives(rules, call, lot) for call in reversed(result.calls) for lot in lots)

    def _answer(self, rules: Rules, result: Result) -> object:
        """What these rules answer to the call by which a case failed."""
        call = result.calls[-1]
        claims = judge(rules, call.arguments, call.answered)
        return tuple((claim.verdict, claim.distance_um, claim.winner) for claim in claims)

    def _gives(self, rules: Rules, call: Call, lot: Lottery = None) -> bool:
        """Whether these rules give exactly that answer."""
        return all(map(self._same, judge(rules, call.arguments, call.answered, lot), call.answered))

    def _same(self, claim: Claim, answered: Asked) -> bool:
        return (
            (claim.verdict, claim.hunter) == (answered.verdict, answered.hunter)
            and (not isinstance(answered.name, OtherTarget) or answered.name.shown == shown(claim.name))
            and (not self._evidence or (claim.distance_um, claim.winner) == (answered.distance_um, answered.winner))
        )


def _is_judged(result: Result) -> bool:
    """Whether a case failed by rulings that could be read."""
    return (
        bool(result.calls)
        and result.failure is not None
        and isinstance(result.failure.differences[0], OtherRuling | OtherLot)
    )
