"""Highlights: moments of recorded matches that are worth seeing, each with its reason and a score.

Each match is played once to extract its events, which give its highlights. `SCORES` has the rule of each kind, and
docs/howto/videos.md has the rules in words.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Final, Literal, NamedTuple

from catch_arena.explanation.captures import PreyRecord
from catch_arena.explanation.contests import contests_of
from catch_arena.explanation.facts import Capture, Contest
from catch_arena.explanation.formatting import metres, seconds, short_length
from catch_arena.explanation.seats import labels, prey_labels, team_label
from catch_arena.replay import Replay
from catch_arena.verdicts import Verdict

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
LAST_MS: Final = 5000
"""Length of a match's final part [ms]."""
STREAK: Final = 3
"""Smallest number of catches in a row that is a streak."""
LEAST_OTHER_MATCHES: Final = 2
"""Smallest number of other matches that gives an entrant a win rate, without which there is no upset."""
REPEAT_FACTOR: Final = 0.7
"""Factor on the scores of a kind for each highlight of that kind that was already selected."""

BEFORE_MS: Final = 2000
AFTER_MS: Final = 1500
"""Parts of the match that are shown before and after a decisive instant [ms]."""


class Catch(NamedTuple):
    """One catch, and the scores after its step."""

    judged_ms: int
    """Time at which the catch was judged [ms since reset]: the beginning of the step (R1.4)."""
    seat: int
    contender: int
    scores: tuple[int, ...]
    """Scores after the step, by contender."""


@dataclass(frozen=True, slots=True)
class MatchEvents:
    """Events of a match, from which its highlights follow. A contender is a team, or a hunter if there are no teams."""

    hunters: tuple[str, ...]
    """Labels of the hunters, by seat, all different."""
    prey: tuple[str, ...]
    """Labels of the prey, by index."""
    names: tuple[str, ...]
    """Labels of the contenders, all different."""
    entrants: tuple[str, ...]
    """Names of the entrants, by contender, which are the same in all matches."""
    duration_ms: int
    reach_um: int
    catches: tuple[Catch, ...]
    contests: tuple[Contest, ...]
    captures: tuple[Capture, ...]

    @property
    def scores(self) -> tuple[int, ...]:
        """Final scores, by contender."""
        return self.catches[-1].scores if self.catches else (0,) * len(self.names)


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

    def overlaps(self, other: "Highlight") -> bool:
        """Return whether the two parts have an instant in common."""
        return self.start_ms < other.end_ms and other.start_ms < self.end_ms


def extract_events(replay: Replay) -> MatchEvents:
    """Play a match again and return its events.

    Raises:
        ReplayError: if the match does not play as recorded.
    """
    period_ms = replay.config.control_period_ms
    catches: list[Catch] = []
    contests: list[Contest] = []
    prey = PreyRecord(replay)
    for world in replay.worlds():
        contests += contests_of(replay, world)
        prey.note(world)
        catches += [
            Catch(world.time_ms - period_ms, ruling.hunter, world.hunters[ruling.hunter].team, world.team_scores)
            for ruling in world.rulings
            if ruling.success
        ]
    hunters, teams = replay.hunter_names, replay.config.teams
    names, entrants = labels(hunters), hunters
    if teams is not None:
        names = tuple(team_label(replay, seats) for seats in teams)
        entrants = tuple(" + ".join(dict.fromkeys(hunters[seat] for seat in seats)) for seats in teams)
    return MatchEvents(
        hunters=labels(hunters),
        prey=prey_labels(replay),
        names=names,
        entrants=entrants,
        duration_ms=replay.duration_ms,
        reach_um=replay.config.reach_um,
        catches=tuple(catches),
        contests=tuple(contests),
        captures=tuple(prey.captures),
    )


def find_highlights(events: MatchEvents, rates: Mapping[str, float] | None = None) -> list[Highlight]:
    """Return all highlights of one match, in the order of time.

    Args:
        events: the match's events.
        rates: the share of its other matches that each entrant won (`win_rates`); without it there are no upsets.
    """
    found = [
        *_contests(events),
        *_captures(events),
        *_leads(events),
        *_streaks(events),
        *_finish(events),
        *_upset(events, rates or {}),
    ]
    return sorted(found, key=lambda highlight: (highlight.decisive_ms, KINDS.index(highlight.kind)))


class WinRecord(NamedTuple):
    """Number of matches played and won by an entrant in a folder; a shared win counts as a fraction."""

    played: int = 0
    won: float = 0.0


def win_records(matches: Iterable[MatchEvents]) -> dict[str, WinRecord]:
    """Return the win records of all entrants."""
    found: dict[str, WinRecord] = {}
    for events in matches:
        best = max(events.scores)
        for name, score in zip(events.entrants, events.scores, strict=True):
            old = found.get(name, WinRecord())
            found[name] = WinRecord(old.played + 1, old.won + (score == best) / events.scores.count(best))
    return found


def win_rates(known: Mapping[str, WinRecord], events: MatchEvents) -> dict[str, float]:
    """Return the share of its other matches that each entrant of a match won, without entrants with too few of them."""
    in_match = win_records([events])
    elsewhere = {
        name: WinRecord(known[name].played - record.played, known[name].won - record.won)
        for name, record in in_match.items()
    }
    return {
        name: record.won / record.played for name, record in elsewhere.items() if record.played >= LEAST_OTHER_MATCHES
    }


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
    winner, loser = contest.claims[:2]
    measured = contest.margin_um is not None and contest.clause in ("R5.4", "R5.5")
    return measured and winner.verdict is Verdict.GRANTED and not loser.mate


def _contests(events: MatchEvents) -> Iterable[Highlight]:
    for contest in filter(has_loser, events.contests):
        winner, loser = contest.claims[:2]
        first, second, margin_um = events.hunters[winner.seat], events.hunters[loser.seat], contest.margin_um or 0
        distances = f"{metres(winner.distance_um)} from {contest.target}"
        if contest.clause == "R5.5":
            event = f"{first} beats {second} by lot"
            reason = f"Both were {distances}: the lowest lot wins (R5.5)"
        else:
            event = f"{first} beats {second} by {short_length(margin_um)}"
            reason = (
                f"{first} was {distances}, {second} {metres(loser.distance_um)}: the smaller distance decides (R5.4)"
            )
        yield _highlight("contest", (margin_um, events.reach_um), contest.judged_ms, event, reason)


def _captures(events: MatchEvents) -> Iterable[Highlight]:
    for capture in events.captures:
        event = f"{events.hunters[capture.seat]} catches {events.prey[capture.prey]}"
        place = "" if capture.distance_um is None else f", from {metres(capture.distance_um)}"
        reason = f"The prey had escaped for {seconds(capture.in_play_ms)}{place} (R12.3)"
        yield _highlight("capture", (capture.in_play_ms, events.duration_ms), capture.judged_ms, event, reason)


def _leads(events: MatchEvents) -> Iterable[Highlight]:
    """Yield a highlight for each change of the sole leader; the catches of one step count together."""
    leader: int | None = None
    since_ms = 0
    for at_ms, step in groupby(events.catches, key=lambda catch: catch.judged_ms):
        made = list(step)
        scores = made[-1].scores
        new = next(
            (catch.contender for catch in made if scores[catch.contender] > _best_other(scores, catch.contender)), None
        )
        if new is None or new == leader:
            continue
        if leader is not None:
            event = f"{events.names[new]} takes the lead, {scores[new]} : {_best_other(scores, new)}"
            reason = f"{events.names[leader]}, which led from {seconds(since_ms)} on, has {scores[leader]} (R6.1)"
            yield _highlight("lead", (at_ms, events.duration_ms), at_ms, event, reason)
        leader, since_ms = new, at_ms


def _streaks(events: MatchEvents) -> Iterable[Highlight]:
    if len(events.hunters) == 1:
        return
    for seat, run in groupby(events.catches, key=lambda catch: catch.seat):
        times = [catch.judged_ms for catch in run]
        if len(times) < STREAK:
            continue
        event = f"{events.hunters[seat]} catches {len(times)} in a row"
        reason = f"For {seconds(times[-1] - times[0])} no other hunter catches a target (R6.1)"
        start_ms = max(times[-STREAK] - 1000, times[-1] - LAST_MS, 0)
        yield _highlight("streak", (len(times),), times[-1], event, reason, start_ms=start_ms)


def _finish(events: MatchEvents) -> Iterable[Highlight]:
    """Yield the final part of a close match."""
    ranked = sorted(range(len(events.names)), key=lambda contender: -events.scores[contender])[:2]
    best, second = (events.scores[contender] for contender in (ranked[0], ranked[-1]))
    difference = best - second
    if len(ranked) == 1 or best == 0 or difference > CLOSE_CATCHES:
        return
    event = f"{', '.join(f'{events.names[contender]} {events.scores[contender]}' for contender in ranked)} at the end"
    lead = "One catch" if difference == 1 else f"A lead of {difference} catches"
    reason = f"{lead} decides the match (R6.1)" if difference else "They share the first rank (R6.1)"
    start_ms, end_ms = max(0, events.duration_ms - LAST_MS), events.duration_ms + AFTER_MS
    late = [catch.judged_ms for catch in events.catches if catch.judged_ms >= start_ms and catch.contender in ranked]
    decisive_ms = late[-1] if late else max(start_ms, events.duration_ms - 1000)
    yield _highlight("finish", (difference, best), decisive_ms, event, reason, start_ms=start_ms, end_ms=end_ms)


def _upset(events: MatchEvents, rates: Mapping[str, float]) -> Iterable[Highlight]:
    """Yield a highlight if the sole winner had won a smaller share of its other matches than the favourite."""
    scores, names = events.scores, events.names
    winner = scores.index(max(scores))
    if scores.count(scores[winner]) > 1 or not all(name in rates for name in events.entrants):
        return
    shares = [rates[name] for name in events.entrants]
    favourite = shares.index(max(shares))
    if shares[favourite] <= shares[winner]:
        return
    at_ms = events.catches[-1].judged_ms
    for catch in reversed(events.catches):  # back to the catch after which the winner always leads alone
        if catch.scores[winner] <= _best_other(catch.scores, winner):
            break
        at_ms = catch.judged_ms
    event = f"{names[winner]} beats {names[favourite]}, {scores[winner]} : {scores[favourite]}"
    winners_share, favourites_share = shares[winner], shares[favourite]
    reason = (
        f"It won {100 * winners_share:.0f} % of its other matches, and {names[favourite]} "
        f"{100 * favourites_share:.0f} %; from here on it leads (R6.1)"
    )
    yield _highlight("upset", (favourites_share, winners_share), at_ms, event, reason)


def _highlight(
    kind: Kind,
    numbers: Sequence[float],
    decisive_ms: int,
    event: str,
    reason: str,
    *,
    start_ms: int | None = None,
    end_ms: int | None = None,
) -> Highlight:
    """Return a highlight with its score; by default it spans a few seconds around the decisive instant."""
    start_ms = max(0, decisive_ms - BEFORE_MS) if start_ms is None else start_ms
    end_ms = decisive_ms + AFTER_MS if end_ms is None else end_ms
    return Highlight(kind, start_ms, decisive_ms, end_ms, max(0.0, SCORES[kind](*numbers)), event, reason)


def _best_other(scores: Sequence[int], contender: int) -> int:
    """Return the best score of all but one contender; -1 if there is no other."""
    return max((score for rival, score in enumerate(scores) if rival != contender), default=-1)
