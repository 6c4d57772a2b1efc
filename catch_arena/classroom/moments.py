"""Choice of the moment of a match that an agent's page plays.

The worst is a failure, a lost contest, refusals, or a long wait; the best is a contest that was won, or a catch.
"""

from itertools import pairwise
from typing import Final

from catch_arena.explanation import explain
from catch_arena.explanation.formatting import seconds
from catch_arena.player.moments import Moment, moment_of
from catch_arena.replay import Replay
from catch_arena.tournament.match import MatchResult
from catch_arena.tournament.parties import Parties

_FAILED: Final = {
    "FORFEIT_CRASH": "crashed",
    "FORFEIT_TIMEOUT": "took too long",
    "FORFEIT_ILLEGAL": "gave an illegal action",
}
"""Captions of failures."""


def merit(result: MatchResult, party: int, hunting: int) -> tuple[bool, int]:
    """Return how well a party did in a match, the higher the better: any failure is worst, then the score counts.

    For one of the `hunting` parties it is the score minus the best other one; prey must not be caught often.
    """
    if result.forfeits[party] is not None:
        return False, 0
    if party >= hunting:
        return True, -result.scores[party]
    others = (score for other, score in enumerate(result.scores[:hunting]) if other != party)
    return True, result.scores[party] - max(others, default=0)


def worst_moment(replay: Replay, party: int, result: MatchResult) -> Moment | None:
    """Return the moment in which a party failed, or else its worst moment in a match; None if it did not begin.

    Raises:
        ReplayError: if the match does not play as recorded.
    """
    seat, forfeit = Parties.of(replay.config).seats[party][0], result.forfeits[party]
    if forfeit is None:
        return moment_of(replay, seat, *_worst_moment(replay, seat))
    if not forfeit.step:
        return None
    seat = seat if forfeit.seat < 0 else forfeit.seat
    at_ms = (forfeit.step - 1) * replay.config.control_period_ms
    return moment_of(replay, seat, at_ms, str(forfeit), f"{_FAILED[forfeit.code]} here, step {forfeit.step}")


def best_moment(replay: Replay, party: int, result: MatchResult) -> Moment | None:
    """Return the contest of a match that a party won by least, or its last catch, or the start; None if it failed.

    Raises:
        ReplayError: if the match does not play as recorded.
    """
    if result.forfeits[party] is not None:
        return None
    seat = Parties.of(replay.config).seats[party][0]
    match = explain(replay, seat)
    won = [contest for contest in match.contests if contest.claims[0].seat == seat and contest.between_teams]
    caught = [catch for catch in match.catches if catch.seat == seat]
    if won:
        closest = min(won, key=lambda contest: contest.margin_um or 0)
        return moment_of(replay, seat, closest.judged_ms, match.sentence(closest))
    if caught:
        return moment_of(
            replay, seat, caught[-1].judged_ms, f"Catch {len(caught)} of {len(caught)}, without a contest."
        )
    return moment_of(replay, seat, 0, "The start of the match; it catches nothing.")


def _worst_moment(replay: Replay, seat: int) -> tuple[int, str]:
    """Return the time [ms since reset] and the text of the worst moment of a seat that did not fail."""
    hunters = replay.config.hunters
    match = explain(replay, seat if seat < hunters else f"prey_{seat - hunters}")
    if seat >= hunters:
        if not match.captures:
            return 0, "It was never caught in this match."
        capture = min(match.captures, key=lambda one: one.in_play_ms)
        return capture.judged_ms, match.sentence(capture)
    lost = [
        (contest.behind_um(claim) or 0, contest)
        for contest in match.contests
        for claim in contest.claims[1:]
        if claim.seat == seat and not claim.mate and contest.clause != "R9.1"
    ]
    if match.refusals and sum(match.records[0].refused.values()) > len(lost):
        run = max(match.refusals, key=lambda one: one.times)
        return run.first_ms, match.sentence(run)
    if lost:
        _, contest = max(lost, key=lambda one: one[0])
        return contest.judged_ms, match.sentence(contest)
    caught = [catch.judged_ms for catch in match.catches if catch.seat == seat]
    start, end = max(pairwise([0, *caught, replay.duration_ms]), key=lambda gap: gap[1] - gap[0])
    return start, f"From {seconds(start)} to {seconds(end)} it catches nothing, its longest wait in this match."
