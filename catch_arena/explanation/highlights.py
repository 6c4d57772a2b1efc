"""Highlights: moments of recorded matches that are worth seeing, each with its reason and a score.

They follow from the facts of `explain`. `SCORES` has the rule of each kind, and docs/howto/videos.md has it in words.
"""

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import Final, Literal

from catch_arena.explanation.facts import Catch, Contest
from catch_arena.explanation.formatting import metres, seconds
from catch_arena.explanation.match_summary import Explanation
from catch_arena.explanation.sentences import margin_phrase

Kind = Literal["contest", "capture", "lead", "streak", "finish", "upset"]

SCORES: Final[Mapping[Kind, Callable[..., float]]] = {
    "contest": lambda margin_um, reach_um: 1.0 - math.log1p(margin_um) / math.log1p(reach_um),
    "capture": lambda in_play_ms, duration_ms: in_play_ms / duration_ms,
    "lead": lambda at_ms, duration_ms: (at_ms / duration_ms) ** 2,
    "streak": lambda catches: 1.0 - 2.0 / catches,
    "finish": lambda difference, most: (1.0 - difference / most) ** 2,
    "upset": lambda favourites_share, winners_share: favourites_share - winners_share,
}
"""Function of each kind that returns a highlight's score in [0, 1] from the numbers of that kind."""
KINDS: Final = tuple(SCORES)

CLOSE_CATCHES: Final = 2
"""Largest difference between the first and the second score of a close match."""
STREAK: Final = 3
"""Smallest number of catches in a row that is a streak."""
LEAST_OTHER_MATCHES: Final = 2
"""Smallest number of other matches that gives an entrant a win rate, without which there is no upset."""
REPEAT_FACTOR: Final = 0.7
"""Factor on the scores of a kind for each highlight of that kind that was already selected."""

BEFORE_MS: Final = 2000
LONG_BEFORE_MS: Final = 5000
AFTER_MS: Final = 1500
"""Parts of the match that are shown before and after a decisive instant [ms]: before a streak and a finish the long
one.
"""


@dataclass(frozen=True, slots=True)
class Highlight:
    """A part of a match that is worth seeing."""

    kind: Kind
    start_ms: int
    decisive_ms: int
    """Decisive instant [ms since reset]."""
    end_ms: int
    """End of the part [ms since reset]; after the match's end, the last picture stays."""
    score: float
    event: str
    reason: str
    clause: str
    """Clause of the rulebook that the event follows from."""

    def overlaps(self, other: "Highlight") -> bool:
        """Return whether the two parts have an instant in common."""
        return self.start_ms < other.end_ms and other.start_ms < self.end_ms


def find_highlights(match: Explanation, rates: Mapping[str, float] | None = None) -> list[Highlight]:
    """Return all highlights of one match, in the order of time; there are upsets only with `rates` (`win_rates`)."""
    found = [
        *_contests(match),
        *_captures(match),
        *_leads(match),
        *_streaks(match),
        *_finish(match),
        *_upset(match, rates or {}),
    ]
    return sorted(found, key=lambda highlight: (highlight.decisive_ms, KINDS.index(highlight.kind)))


def win_rates(matches: Iterable[Explanation]) -> list[dict[str, float]]:
    """Return for each match the share of its other matches that each entrant won, without entrants with too few of
    them; a shared win counts as a fraction.
    """
    shares: list[list[tuple[str, float]]] = []
    by_entrant: dict[str, list[float]] = defaultdict(list)
    for match in matches:
        scores = list(match.contenders.values())
        won = [(score == max(scores)) / scores.count(max(scores)) for score in scores]
        shares.append(list(zip(match.entrants, won, strict=True)))
        for name, share in shares[-1]:
            by_entrant[name].append(share)
    rates: list[dict[str, float]] = [{} for _ in shares]
    for own, found in zip(shares, rates, strict=True):
        for name in dict(own):
            here = [share for entrant, share in own if entrant == name]
            others = len(by_entrant[name]) - len(here)
            if others >= LEAST_OTHER_MATCHES:
                found[name] = (sum(by_entrant[name]) - sum(here)) / others
    return rates


def best_highlights(matches: Mapping[str, Explanation], count: int) -> list[tuple[str, Highlight]]:
    """Return at most `count` of the best highlights of some matches, each with its match's key, the best one last."""
    rates = win_rates(matches.values())
    found = {key: find_highlights(match, known) for (key, match), known in zip(matches.items(), rates, strict=True)}
    return select_highlights(found, count)


def select_highlights(found: Mapping[str, Sequence[Highlight]], count: int) -> list[tuple[str, Highlight]]:
    """Return at most `count` of the best highlights, each with its match's key in `found`, the best one last.

    No two of one match overlap. The score of a kind that was taken k times is multiplied by REPEAT_FACTOR ** k.
    """
    left = [(place, highlight) for place in sorted(found) for highlight in found[place]]
    chosen: list[tuple[str, Highlight]] = []
    taken = dict.fromkeys(KINDS, 0)
    while left and len(chosen) < count:
        place, highlight = max(left, key=lambda item: item[1].score * REPEAT_FACTOR ** taken[item[1].kind])
        chosen.append((place, highlight))
        taken[highlight.kind] += 1
        left = [item for item in left if item[0] != place or not item[1].overlaps(highlight)]
    return chosen[::-1]


def has_loser(contest: Contest) -> bool:
    """Return whether the distance, or a lot among equally near hunters, gave the target to another team's hunter."""
    return contest.between_teams and contest.clause in ("R5.4", "R5.5")


def _contests(match: Explanation) -> Iterable[Highlight]:
    for contest in filter(has_loser, match.contests):
        winner, loser = contest.claims[:2]
        first, second, margin_um = match.names[winner.seat], match.names[loser.seat], contest.margin_um or 0
        rule = "the lowest lot wins" if contest.clause == "R5.5" else "the smaller distance decides"
        reason = (
            f"{first} was {metres(winner.distance_um)} from {contest.target}, {second} {metres(loser.distance_um)}: "
            f"{rule}"
        )
        event = f"{first} beats {second} {margin_phrase(contest)}"
        numbers = margin_um, max(match.reaches_um)
        yield _highlight("contest", numbers, contest.judged_ms, event, reason, contest.clause)


def _captures(match: Explanation) -> Iterable[Highlight]:
    for capture in match.captures:
        event = f"{match.names[capture.seat]} catches {match.prey_names[capture.prey]}"
        place = "" if capture.distance_um is None else f", from {metres(capture.distance_um)}"
        reason = f"The prey had escaped for {seconds(capture.in_play_ms)}{place}"
        yield _highlight("capture", (capture.in_play_ms, match.duration_ms), capture.judged_ms, event, reason, "R12.3")


def _changes_of_lead(match: Explanation) -> list[tuple[int, Catch]]:
    """Return each contender that leads alone after another one, and the catch that made it the leader."""
    found: list[tuple[int, Catch]] = []
    for catch in match.catches:
        leader, _ = lead(catch.scores)
        if leader is not None and (not found or leader != found[-1][0]):
            found.append((leader, catch))
    return found


def _leads(match: Explanation) -> Iterable[Highlight]:
    names = list(match.contenders)
    for (old, before), (new, after) in pairwise(_changes_of_lead(match)):
        scores, at_ms = after.scores, after.judged_ms
        event = f"{names[new]} takes the lead, {scores[new]} : {sorted(scores)[-2]}"
        reason = f"{names[old]}, which led from {seconds(before.judged_ms)} on, has {scores[old]}"
        yield _highlight("lead", (at_ms, match.duration_ms), at_ms, event, reason, "R6.1")


def _streaks(match: Explanation) -> Iterable[Highlight]:
    if len(match.names) == 1:
        return
    for seat, run in groupby(match.catches, key=lambda catch: catch.seat):
        times = [catch.judged_ms for catch in run]
        if len(times) < STREAK:
            continue
        event = f"{match.names[seat]} catches {len(times)} in a row"
        reason = f"For {seconds(times[-1] - times[0])} no other hunter catches a target"
        yield _highlight("streak", (len(times),), times[-1], event, reason, "R6.1", LONG_BEFORE_MS)


def _finish(match: Explanation) -> Iterable[Highlight]:
    """Yield the final part of a close match."""
    ranked = sorted(match.contenders.items(), key=lambda item: -item[1])[:2]
    best, difference = ranked[0][1], ranked[0][1] - ranked[-1][1]
    if len(ranked) == 1 or best == 0 or difference > CLOSE_CATCHES:
        return
    event = f"{', '.join(f'{name} {score}' for name, score in ranked)} at the end"
    decides = "One catch decides" if difference == 1 else f"{difference} catches decide"
    reason = f"{decides} the match" if difference else "They share the first rank"
    decisive_ms = max(match.catches[-1].judged_ms, match.duration_ms - 1000)
    yield _highlight("finish", (difference, best), decisive_ms, event, reason, "R6.1", LONG_BEFORE_MS)


def _upset(match: Explanation, rates: Mapping[str, float]) -> Iterable[Highlight]:
    """Yield a highlight if the sole winner had won a smaller share of its other matches than the favourite."""
    names, scores = zip(*match.contenders.items(), strict=True)
    winner, _ = lead(scores)
    if winner is None or not rates.keys() >= set(match.entrants):
        return
    shares = [rates[name] for name in match.entrants]
    favourite = shares.index(max(shares))
    if shares[favourite] <= shares[winner]:
        return
    at_ms = _changes_of_lead(match)[-1][1].judged_ms
    event = f"{names[winner]} beats {names[favourite]}, {scores[winner]} : {scores[favourite]}"
    reason = (
        f"It won {100 * shares[winner]:.0f} % of its other matches, and {names[favourite]} "
        f"{100 * shares[favourite]:.0f} %; from here on it leads"
    )
    yield _highlight("upset", (shares[favourite], shares[winner]), at_ms, event, reason, "R6.1")


def _highlight(
    kind: Kind,
    numbers: Sequence[float],
    decisive_ms: int,
    event: str,
    reason: str,
    clause: str,
    before_ms: int = BEFORE_MS,
) -> Highlight:
    """Return a highlight with its score, which spans a few seconds around the decisive instant."""
    start_ms, end_ms = max(0, decisive_ms - before_ms), decisive_ms + AFTER_MS
    return Highlight(kind, start_ms, decisive_ms, end_ms, SCORES[kind](*numbers), event, reason, clause)


def lead(scores: Sequence[int]) -> tuple[int | None, int]:
    """Return the leader and its lead over the next, or (None, 0) for a tie. A single contender leads by its score."""
    best = max(scores, default=0)
    if list(scores).count(best) != 1 or best == 0:
        return None, 0
    return list(scores).index(best), best - max((score for score in scores if score != best), default=0)
