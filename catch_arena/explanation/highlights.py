"""Highlights: the moments of recorded matches that are worth seeing, each with its reason and a score.

Pure: a match is played once for its events, and its highlights follow from these. Scores lie in [0, 1]; each kind has
one rule, and docs/videos.md lists them.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Final, Literal, NamedTuple, get_args

from catch_arena.explanation.captures import PreyRecord
from catch_arena.explanation.contests import contests_of
from catch_arena.explanation.facts import Capture, Contest
from catch_arena.explanation.formatting import metres, seconds, short_length
from catch_arena.explanation.seats import labels, prey_labels, team_label
from catch_arena.replay import Replay
from catch_arena.verdicts import Verdict

Kind = Literal["contest", "capture", "lead", "streak", "finish", "upset"]
KINDS: Final[tuple[Kind, ...]] = get_args(Kind)

CLOSE_CATCHES: Final = 2
"""A match that ends with no more between the first and the second was close."""
LAST_MS: Final = 5000
"""The last seconds of a match."""
STREAK: Final = 3
"""So many catches in a row are a streak."""
LEAST_OTHER_MATCHES: Final = 2
"""Who has played fewer others has no record yet, and nothing that it does is an upset."""
REPEAT_FACTOR: Final = 0.7
"""Each highlight of a kind that is taken already makes the others of that kind count so much less."""

_BEFORE_MS: Final = 2000
_AFTER_MS: Final = 1500


class Catch(NamedTuple):
    """One catch, and the scores that it led to."""

    judged_ms: int
    """When it was judged: the step's beginning (R1.4)."""
    seat: int
    contender: int
    scores: tuple[int, ...]
    """By contender."""


@dataclass(frozen=True, slots=True)
class MatchEvents:
    """What a match's highlights are found by. A contender is a team, or where there are none a hunter."""

    hunters: tuple[str, ...]
    """By seat, each once."""
    prey: tuple[str, ...]
    """By index."""
    names: tuple[str, ...]
    """By contender, each once."""
    entrants: tuple[str, ...]
    """By contender, as they are called in other matches too."""
    duration_ms: int
    reach_um: int
    catches: tuple[Catch, ...]
    contests: tuple[Contest, ...]
    captures: tuple[Capture, ...]

    @property
    def scores(self) -> tuple[int, ...]:
        """The final ones."""
        return self.catches[-1].scores if self.catches else (0,) * len(self.names)


@dataclass(frozen=True, slots=True)
class Highlight:
    """A part of a match that is worth seeing."""

    kind: Kind
    start_ms: int
    decisive_ms: int
    """The instant that it is about."""
    end_ms: int
    """After the match's end its last picture stays."""
    score: float
    what: str
    why: str

    def overlaps(self, other: "Highlight") -> bool:
        """Some instant belongs to both."""
        return self.start_ms < other.end_ms and other.start_ms < self.end_ms


def extract_events(replay: Replay, progress: Callable[[int, int], None] | None = None) -> MatchEvents:
    """A match, played again.

    Raises:
        ReplayError: where it does not play as recorded.
    """
    period_ms = replay.config.control_period_ms
    catches: list[Catch] = []
    contests: list[Contest] = []
    prey = PreyRecord(replay)
    for step, world in enumerate(replay.worlds()):
        contests += contests_of(replay, world)
        prey.note(world)
        catches += [
            Catch(world.time_ms - period_ms, ruling.hunter, world.hunters[ruling.hunter].team, world.team_scores)
            for ruling in world.rulings
            if ruling.success
        ]
        if progress is not None:
            progress(step, replay.steps)
    names, entrants = labels(replay.hunter_names), replay.hunter_names
    hunters = names
    if replay.config.teams is not None:
        names = tuple(team_label(replay, seats) for seats in replay.config.teams)
        entrants = tuple(_entrant(replay, seats) for seats in replay.config.teams)
    return MatchEvents(
        hunters,
        prey_labels(replay),
        names,
        entrants,
        replay.steps * period_ms,
        replay.config.reach_um,
        tuple(catches),
        tuple(contests),
        tuple(prey.captures),
    )


def _entrant(replay: Replay, seats: Sequence[int]) -> str:
    """A team as it is called in other matches: by its only agent, or by all of them."""
    return " + ".join(dict.fromkeys(replay.hunter_names[seat] for seat in seats))


def find_highlights(events: MatchEvents, rates: Mapping[str, float] | None = None) -> list[Highlight]:
    """All that is worth seeing in one match, in the order of time.

    Args:
        events: the match's events.
        rates: the share of their other matches that the entrants won (`win_rates`): without it there are no upsets.
    """
    found = [
        *_contests(events),
        *_captures(events),
        *_leads(events),
        *_streaks(events),
        *_finish(events),
        *_upset(events, rates or {}),
    ]
    return sorted(found, key=lambda one: (one.decisive_ms, KINDS.index(one.kind)))


class WinRecord(NamedTuple):
    """What an entrant has done in a folder's matches; who shares a win has a part of it."""

    played: int = 0
    won: float = 0.0


def win_records(matches: Iterable[MatchEvents]) -> dict[str, WinRecord]:
    """The records of all entrants."""
    found: dict[str, WinRecord] = {}
    for events in matches:
        for name, share in zip(events.entrants, _shares(events), strict=True):
            old = found.get(name, WinRecord())
            found[name] = WinRecord(old.played + 1, old.won + share)
    return found


def win_rates(known: Mapping[str, WinRecord], events: MatchEvents) -> dict[str, float]:
    """The share of their other matches that a match's entrants won; who has no record yet is left out."""
    mine = win_records([events])
    others = {name: WinRecord(known[name].played - one.played, known[name].won - one.won) for name, one in mine.items()}
    return {name: one.won / one.played for name, one in others.items() if one.played >= LEAST_OTHER_MATCHES}


def _shares(events: MatchEvents) -> list[float]:
    """By contender, its part of the win."""
    most = max(events.scores)
    return [(score == most) / events.scores.count(most) for score in events.scores]


def select_highlights(
    found: Mapping[str, Sequence[Highlight]],
    count: int,
    clash: Callable[[Highlight, Highlight], bool] = Highlight.overlaps,
) -> list[tuple[str, Highlight]]:
    """The most worth seeing, with where they are from, the best one last; fewer where there are no more.

    No two of one match `clash`, and a kind that was taken k times already counts REPEAT_FACTOR ** k.
    """
    left = [(place, one) for place in sorted(found) for one in found[place]]
    chosen: list[tuple[str, Highlight]] = []
    taken = dict.fromkeys(KINDS, 0)
    while left and len(chosen) < count:
        place, one = max(left, key=lambda item: item[1].score * REPEAT_FACTOR ** taken[item[1].kind])
        chosen.append((place, one))
        taken[one.kind] += 1
        left = [item for item in left if item[0] != place or not clash(item[1], one)]
    return chosen[::-1]


def _contests(events: MatchEvents) -> Iterable[Highlight]:
    """The nearer the two were to the same distance, the better: 1 for a lot, 0 where one of them was at the target."""
    for contest in events.contests:
        margin_um = contest.margin_um
        winner, loser = contest.claims[:2]
        if loser.mate:
            continue  # nobody has lost anything by it
        if margin_um is None or winner.verdict is not Verdict.GRANTED or contest.clause not in ("R5.4", "R5.5"):
            continue
        first, second = events.hunters[winner.seat], events.hunters[loser.seat]
        distances = f"{metres(winner.distance_um)} from {contest.target}"
        if contest.clause == "R5.5":
            what = f"{first} beats {second} by lot"
            why = f"Both were {distances}: the lowest lot wins (R5.5)"
        else:
            what = f"{first} beats {second} by {short_length(margin_um)}"
            why = f"It was {distances}, the other {metres(loser.distance_um)}: the smaller distance decides (R5.4)"
        score = 1.0 - math.log1p(margin_um) / math.log1p(events.reach_um)
        yield _around("contest", contest.judged_ms, score, what, why)


def _captures(events: MatchEvents) -> Iterable[Highlight]:
    """The longer prey had got away, the better: that part of the match."""
    for one in events.captures:
        what = f"{events.hunters[one.seat]} catches {events.prey[one.prey]}"
        place = "" if one.distance_um is None else f", from {metres(one.distance_um)}"
        why = f"It had got away for {seconds(one.in_play_ms)}{place} (R12.3)"
        score = one.in_play_ms / events.duration_ms
        yield _around("capture", one.judged_ms, score, what, why)


def _leads(events: MatchEvents) -> Iterable[Highlight]:
    """The later somebody else takes the lead, the better: the square of the part of the match that has passed."""
    for since_ms, catch, old in _changes(events):
        scores = catch.scores
        what = f"{events.names[catch.contender]} takes the lead, {scores[catch.contender]} : {_second(scores)}"
        why = f"{events.names[old]}, who was in front from {seconds(since_ms)} on, has {scores[old]} (R6.1)"
        yield _around("lead", catch.judged_ms, (catch.judged_ms / events.duration_ms) ** 2, what, why)


def _changes(events: MatchEvents) -> Iterable[tuple[int, Catch, int]]:
    """Since when the old one led, the catch that changed it, and the old one; ties have no leader."""
    leader: int | None = None
    since_ms = 0
    for _, step in groupby(events.catches, key=lambda catch: catch.judged_ms):
        catch = _leading(tuple(step))
        if catch is None or catch.contender == leader:
            continue
        if leader is not None:
            yield since_ms, catch, leader
        leader, since_ms = catch.contender, catch.judged_ms


def _leading(step: Sequence[Catch]) -> Catch | None:
    """The catch of a step by which somebody leads alone after it."""
    scores = step[-1].scores
    return next((one for one in step if scores[one.contender] > _second(scores, one.contender)), None)


def _streaks(events: MatchEvents) -> Iterable[Highlight]:
    """The longer, the better: 1 - 2 / n for n catches in a row."""
    if len(events.hunters) == 1:
        return
    for seat, run in groupby(events.catches, key=lambda catch: catch.seat):
        row = list(run)
        if len(row) < STREAK:
            continue
        first, last = row[0], row[-1]
        what = f"{events.hunters[seat]} catches {len(row)} in a row"
        why = f"For {seconds(last.judged_ms - first.judged_ms)} nobody else catches any (R6.1)"
        start_ms = max(row[-STREAK].judged_ms - 1000, last.judged_ms - LAST_MS, 0)
        end_ms = last.judged_ms + _AFTER_MS
        yield Highlight("streak", start_ms, last.judged_ms, end_ms, 1.0 - 2.0 / len(row), what, why)


def _finish(events: MatchEvents) -> Iterable[Highlight]:
    """The last seconds: the smaller the winner's lead as a part of its catches, the better, squared."""
    scores = sorted(events.scores, reverse=True)
    if len(scores) == 1 or scores[0] == 0 or scores[0] - scores[1] > CLOSE_CATCHES:
        return
    first, second = sorted(range(len(scores)), key=lambda contender: (-events.scores[contender], contender))[:2]
    names = f"{events.names[first]} {scores[0]}, {events.names[second]} {scores[1]}"
    what = f"{names} at the end"
    why = (
        "They share the first rank (R6.1)" if scores[0] == scores[1] else f"{_catches(scores)} decides the match (R6.1)"
    )
    start_ms = max(0, events.duration_ms - LAST_MS)
    late = [one.judged_ms for one in events.catches if one.judged_ms >= start_ms and one.contender in (first, second)]
    decisive_ms = late[-1] if late else max(start_ms, events.duration_ms - 1000)
    score = (1.0 - (scores[0] - scores[1]) / scores[0]) ** 2
    yield Highlight("finish", start_ms, decisive_ms, events.duration_ms + _AFTER_MS, score, what, why)


def _upset(events: MatchEvents, rates: Mapping[str, float]) -> Iterable[Highlight]:
    """How much more of its other matches the favourite had won than the winner."""
    winner = events.scores.index(max(events.scores))
    if events.scores.count(events.scores[winner]) > 1 or not all(name in rates for name in events.entrants):
        return
    favourite = max(range(len(events.names)), key=lambda contender: rates[events.entrants[contender]])
    mine, theirs = rates[events.entrants[winner]], rates[events.entrants[favourite]]
    if theirs <= mine:
        return
    taken = [catch for catch in events.catches if _leads_from(events, catch, winner)]
    what = (
        f"{events.names[winner]} beats {events.names[favourite]}, {events.scores[winner]} : {events.scores[favourite]}"
    )
    why = (
        f"Of its other matches it won {100 * mine:.0f} %, {events.names[favourite]} {100 * theirs:.0f} %; "
        "from here on it leads (R6.1)"
    )
    yield _around("upset", taken[0].judged_ms, theirs - mine, what, why)


def _leads_from(events: MatchEvents, catch: Catch, contender: int) -> bool:
    """From this catch to the end this contender leads alone."""
    later = (one.scores for one in events.catches if one.judged_ms >= catch.judged_ms)
    return all(scores[contender] > _second(scores, contender) for scores in later)


def _around(kind: Kind, decisive_ms: int, score: float, what: str, why: str) -> Highlight:
    start_ms = max(0, decisive_ms - _BEFORE_MS)
    return Highlight(kind, start_ms, decisive_ms, decisive_ms + _AFTER_MS, max(0.0, score), what, why)


def _second(scores: Sequence[int], contender: int | None = None) -> int:
    """The best score but one; or the best of all but that contender's, -1 for one alone."""
    if contender is None:
        contender = scores.index(max(scores))
    return max((score for other, score in enumerate(scores) if other != contender), default=-1)


def _catches(scores: Sequence[int]) -> str:
    return "One catch" if scores[0] - scores[1] == 1 else f"A lead of {scores[0] - scores[1]} catches"
