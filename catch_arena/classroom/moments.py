"""Worst moment of a student's matches, for the student's page: a failure, a lost contest, refusals, or a long wait."""

import json
from itertools import islice, pairwise
from typing import Final

import msgspec

from catch_arena.explanation import explain
from catch_arena.explanation.formatting import seconds
from catch_arena.player import packed_text
from catch_arena.player.bundle import encode_bundle
from catch_arena.replay import Replay
from catch_arena.replay.fileformat import decode_replay
from catch_arena.tournament.match import Forfeit, MatchResult
from catch_arena.tournament.parties import Parties

_FAILED: Final = {
    "FORFEIT_CRASH": "crashed",
    "FORFEIT_TIMEOUT": "took too long",
    "FORFEIT_ILLEGAL": "gave an illegal action",
}
"""Captions of failures."""


class Moment(msgspec.Struct, frozen=True):
    """Moment of a match that the page plays."""

    title: str
    """Test and match."""
    text: str
    at_ms: int
    """Time of the moment, from the reset [ms]."""
    seat: int | None
    """The student's seat; None for prey, which the player cannot select."""
    stopped: bool
    """True if the agent failed in that moment."""
    bundle: str
    """Replay bundle of the match, without its seed."""


class WorstMatch:
    """Worst match of a student in a test so far: the first forfeit, else the worst score against the best other.

    Its method `keep` is for `grade_agent`.

    Args:
        parties: the parties of the test's arena.
    """

    def __init__(self, parties: Parties) -> None:
        self._parties = parties
        self._worst: tuple[bool, int] | None = None
        self._replay = b""
        self._seat = 0
        self._forfeit: Forfeit | None = None
        self.log = ""
        """Output of the student's agent in the match."""

    def keep(self, party: int, result: MatchResult, replay: bytes) -> None:
        """Keep a match if it is worse than all before."""
        forfeit, hunting = result.forfeits[party], self._parties.hunting
        behind = result.scores[party] if party >= hunting else -lead(result, party, hunting)
        badness = (True, 0) if forfeit is not None else (False, behind)
        if self._worst is None or badness > self._worst:
            self._worst, self._replay, self._forfeit, self.log = badness, replay, forfeit, result.logs[party]
            self._seat = self._parties.seats[party][0]

    def moment(self) -> Moment | None:
        """Return the worst moment of the match; None if the agent did not begin it.

        Raises:
            ReplayError: if the match does not play as recorded.
        """
        if self._worst is None or (self._forfeit is not None and not self._forfeit.step):
            return None
        return worst_moment(decode_replay(self._replay), self._seat, self._forfeit)


def lead(result: MatchResult, party: int, hunting: int) -> int:
    """Return the score of a party minus the best score of the others, among the `hunting` parties that hunt."""
    others = (score for other, score in enumerate(result.scores[:hunting]) if other != party)
    return result.scores[party] - max(others, default=0)


def worst_moment(replay: Replay, seat: int, forfeit: Forfeit | None) -> Moment:
    """Return the moment of an agent's failure, in the seat that failed, or else its worst moment in a match.

    Raises:
        ReplayError: if the match does not play as recorded.
    """
    if forfeit is None:
        return moment_of(replay, seat, *_worst_moment(replay, seat))
    seat = seat if forfeit.seat < 0 else forfeit.seat
    at_ms = (forfeit.step - 1) * replay.config.control_period_ms
    return moment_of(replay, seat, at_ms, str(forfeit), f"{_FAILED[forfeit.code]} here, step {forfeit.step}")


def moment_of(replay: Replay, seat: int, at_ms: int, text: str, failed: str = "") -> Moment:
    """Return a moment of a match, whose bundle has no seed.

    Args:
        replay: the match.
        seat: the agent's seat; prey come after the hunters.
        at_ms: time of the moment [ms since reset].
        text: text about the moment.
        failed: caption for the picture if the agent failed.

    Raises:
        ReplayError: if the match does not play as recorded.
    """
    head, _, tracks = encode_bundle(replay).partition(b"\n")
    facts = json.loads(head) | {"seed": "hidden"}
    hunter = seat if seat < replay.config.hunters else None
    if failed and hunter is not None:
        caption = f"{facts['hunters'][hunter]['label']} {failed}"
        world = next(islice(replay.worlds(), at_ms // replay.config.control_period_ms, None))
        low = world.hunters[hunter].y < replay.config.side_m / 2  # the caption must not cover the hunter
        moment = {"time": at_ms, "agent": hunter, "text": caption, "atTop": low, "contest": None}
        facts["moments"] = sorted([*facts["moments"], moment], key=lambda one: int(one["time"]))
    content = json.dumps(facts, separators=(",", ":"), ensure_ascii=False)
    return Moment(replay.title, text, at_ms, hunter, bool(failed), packed_text(content.encode() + b"\n" + tracks))


def _worst_moment(replay: Replay, seat: int) -> tuple[int, str]:
    """Return the time [ms since reset] and the text of the worst moment of a seat that did not fail."""
    hunters = replay.config.hunters
    match = explain(replay, seat if seat < hunters else f"prey_{seat - hunters}")
    if seat >= hunters:
        if not match.captures:
            return 0, "It was never caught in this match."
        capture = min(match.captures, key=lambda one: one.in_play_ms)
        return capture.judged_ms, match.sentence(capture)
    lost = {
        claim.distance_um or 0: contest
        for contest in match.contests
        for claim in contest.claims[1:]
        if claim.seat == seat and not claim.mate and contest.clause != "R9.1"
    }
    if match.refusals and sum(match.records[0].refused.values()) > len(lost):
        run = max(match.refusals, key=lambda one: one.times)
        return run.first_ms, match.sentence(run)
    if lost:
        contest = lost[max(lost)]
        return contest.judged_ms, match.sentence(contest)
    caught = [catch.judged_ms for catch in match.catches if catch.seat == seat]
    start, end = max(pairwise([0, *caught, replay.duration_ms]), key=lambda gap: gap[1] - gap[0])
    return start, f"From {seconds(start)} to {seconds(end)} it catches nothing, its longest wait in this match."
