"""Which of the known mistakes an adjudicator has, by what it answered."""

import operator
from collections.abc import Iterable, Sequence
from typing import Final

from catch_arena.conformance.answers import WrongTarget
from catch_arena.conformance.comparison import Call, Strictness, WrongLot, WrongRuling
from catch_arena.conformance.mistakes.known_mistakes import KNOWN, Mistake, mistaken_verdicts, rules_with
from catch_arena.conformance.mistakes.replaceable_rules import Lottery, Request, Rules, judge
from catch_arena.conformance.results import Result
from catch_arena.text import in_short
from catch_arena.verdicts import Ruling, Verdict

_FIRST: Final[Lottery] = operator.itemgetter(0)
_LAST: Final[Lottery] = operator.itemgetter(-1)


class Search:
    """The known mistakes that together answer as an adjudicator does in the most cases.

    A failure is explained by rules that give its very answers, in every variant that was played until it failed.
    """

    def __init__(self, results: Sequence[Result], strictness: Strictness) -> None:
        self._evidence = strictness.evidence
        self._success_only = strictness.success_only
        self._passed = [result for result in results if result.failure is None and result.calls]
        self._failed = [result for result in results if _is_judged(result)]
        self._inconsistent = {
            result.case.id for result in self._failed if all(self._gives(Rules(), call) for call in result.calls)
        }
        self._helps: dict[tuple[str, object, str], bool] = {}

    def has_inconsistent_lots(self, result: Result) -> bool:
        """Whether each answer to a failed case could have been right alone: its lots do not go together."""
        return result.case.id in self._inconsistent

    def mistakes(self) -> list[Mistake]:
        """One after the other, each time the one with which the most failures are explained, less the passes that it
        would have failed.
        """
        seen = {
            (one.right.verdict, one.given.verdict): None
            for result in self._failed
            for one in (result.failure.differences if result.failure else ())
            if isinstance(one, WrongRuling)
        }
        candidates = [*KNOWN, *(() if self._success_only else mistaken_verdicts(seen))]
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

    def behind(self, found: Sequence[Mistake], result: Result) -> list[Mistake]:
        """As few of the mistakes found as explain a failure; none where they do not."""
        if not _is_judged(result) or not self._explains(rules_with(found), result):
            return []
        for one in found:
            if self._explains(rules_with([one]), result):
                return [one]
        needed = list(found)
        for one in found:
            fewer = [other for other in needed if other is not one]
            if self._explains(rules_with(fewer), result):
                needed = fewer
        return needed

    def _helped_by(self, found: Sequence[Mistake], candidates: Iterable[Mistake]) -> list[tuple[Mistake, int]]:
        """About how many more failures each of the candidates explains, most first.

        That is worked out once for each answer that the mistakes found so far lead to: they seldom matter otherwise.
        """
        base = rules_with(found)
        left = [(result, self._answer(base, result)) for result in self._failed if not self._explains(base, result)]
        helped = []
        for one in candidates:
            rules = rules_with([*found, one])
            count = 0
            for result, so_far in left:
                key = (result.case.id, so_far, one.looks_like)
                if key not in self._helps:
                    self._helps[key] = self._explains(rules, result)
                count += self._helps[key]
            helped.append((one, count))
        return sorted(helped, key=lambda pair: -pair[1])

    def _explained(self, mistakes: Sequence[Mistake]) -> int:
        rules = rules_with(mistakes)
        return sum(self._explains(rules, result) for result in self._failed)

    def _contradicted(self, mistakes: Sequence[Mistake]) -> int:
        """How many cases were passed that these mistakes would have failed."""
        rules = rules_with(mistakes)
        return sum(not self._gives(rules, result.calls[0]) for result in self._passed)

    def _explains(self, rules: Rules, result: Result) -> bool:
        # where only the lots are at fault, the rules must draw so by themselves
        lots = (_FIRST, _LAST) if self.has_inconsistent_lots(result) else (None,)
        return all(self._gives(rules, call, lot) for call in reversed(result.calls) for lot in lots)

    def _answer(self, rules: Rules, result: Result) -> object:
        """What these rules answer to the call by which a case failed."""
        call = result.calls[-1]
        requests = judge(rules, call.arguments, call.rulings)
        return tuple((request.verdict, request.distance_um, request.winner) for request in requests)

    def _gives(self, rules: Rules, call: Call, lot: Lottery = None) -> bool:
        """Whether these rules give exactly that answer."""
        return all(map(self._same, judge(rules, call.arguments, call.rulings, lot), call.rulings))

    def _same(self, request: Request, ruling: Ruling) -> bool:
        if self._success_only:
            return request.hunter == ruling.hunter and (request.verdict is Verdict.GRANTED) == ruling.success
        return (
            (request.verdict, request.hunter) == (ruling.verdict, ruling.hunter)
            and (not isinstance(ruling.target, WrongTarget) or ruling.target.in_short == in_short(request.name))
            and (not self._evidence or (request.distance_um, request.winner) == (ruling.distance_um, ruling.winner))
        )


def _is_judged(result: Result) -> bool:
    """Whether a case failed by rulings that could be read."""
    return (
        bool(result.calls)
        and result.failure is not None
        and isinstance(result.failure.differences[0], WrongRuling | WrongLot)
    )
