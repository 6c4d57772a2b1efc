"""Highlights of made-up and played matches have the right kind, time, score and caption."""

from dataclasses import replace

import pytest

from catch_arena.explanation import Explanation, explain
from catch_arena.explanation.facts import Capture, Catch, Claim, Contest
from catch_arena.explanation.highlights import (
    REPEAT_FACTOR,
    Highlight,
    find_highlights,
    select_highlights,
    win_rates,
)
from catch_arena.verdicts import Verdict


def match_with(catches=(), contests=(), names=("ann", "bob", "cy"), captures=()) -> Explanation:
    """The facts of a match in which these hunters catch at these times: (ms, seat)."""
    scores = [0] * len(names)
    rows = []
    for time_ms, contender in catches:
        scores[contender] += 1
        rows.append(Catch(time_ms, contender, tuple(scores)))
    return Explanation(
        title="",
        policy="nearest",
        hunters_per_catch=1,
        reaches_um=(300_000,) * len(names),
        steps=600,
        duration_ms=60_000,
        names=names,
        prey_names=("pip (prey_0)",),
        prey_by_target={},
        scores=tuple(scores),
        entrants=names,
        catches=tuple(rows),
        contests=tuple(contests),
        refusals=(),
        records=(),
        teams=(),
        captures=tuple(captures),
        prey=(),
    )


def contest(margin_um: int, *, clause="R5.4", verdict=Verdict.GRANTED, at_ms=5000) -> Contest:
    claims = (Claim(1, verdict, 120_000), Claim(0, Verdict.LOST_CONTEST, 120_000 + margin_um))
    return Contest(at_ms // 100 + 1, at_ms, "target_turtle_7", clause, claims)


def of_kind(kind, *args, **kwargs) -> list[Highlight]:
    return [one for one in find_highlights(*args, **kwargs) if one.kind == kind]


def test_a_quiet_match_has_none():
    assert find_highlights(match_with()) == []
    assert find_highlights(match_with(names=("alone",), catches=[(1000 * k, 0) for k in range(9)])) == []


def test_a_contest_says_who_won_by_how_much_and_why():
    (one,) = of_kind("contest", match_with(contests=[contest(213)]))
    assert one.event == "bob beats ann by 0.21 mm"
    assert one.reason == "bob was 0.120000 m from target_turtle_7, ann 0.120213 m: the smaller distance decides"
    assert one.clause == "R5.4"
    assert (one.decisive_ms, one.start_ms, one.end_ms) == (5000, 3000, 6500)


def test_the_closer_a_contest_the_better_and_a_lot_is_best():
    scores = [of_kind("contest", match_with(contests=[contest(um)]))[0].score for um in (1, 50, 2000, 90_000)]
    lot = of_kind("contest", match_with(contests=[contest(0, clause="R5.5")]))[0]
    assert lot.score == 1.0 > scores[0]
    assert scores == sorted(scores, reverse=True)
    assert scores[-1] > 0
    assert "by lot" in lot.event
    assert lot.clause == "R5.5"


@pytest.mark.parametrize(
    "other", [contest(5, clause="R9.1"), contest(5, clause="R5.9"), contest(5, verdict=Verdict.KILL_FAILED)]
)
def test_contests_that_distance_did_not_decide_or_that_caught_nothing_are_none(other):
    assert of_kind("contest", match_with(contests=[other])) == []


def test_the_lead_changes_where_another_leads_alone_ties_between_or_not():
    catches = [(1000, 0), (2000, 1), (3000, 0), (20_000, 1), (40_000, 1), (50_000, 1)]
    (one,) = of_kind("lead", match_with(catches))
    assert (one.decisive_ms, one.event) == (40_000, "bob takes the lead, 3 : 2")
    assert one.reason == "ann, which led from 1.0 s on, has 2"
    assert one.score == pytest.approx((40 / 60) ** 2)


def test_a_streak_is_three_or_more_in_a_row():
    assert of_kind("streak", match_with([(1000, 0), (2000, 0), (3000, 1), (4000, 0)])) == []
    (three,) = of_kind("streak", match_with([(1000, 1), (2000, 1), (3000, 1), (4000, 0)]))
    (six,) = of_kind("streak", match_with([(1000 * k, 1) for k in range(1, 7)]))
    assert three.event == "bob catches 3 in a row"
    assert three.reason == "For 2.0 s no other hunter catches a target"
    assert 0 < three.score < six.score < 1
    assert six.decisive_ms == 6000
    assert six.start_ms == 1000  # its last catches, not the whole of it


def test_the_end_of_a_close_match_is_seen_and_of_no_other():
    close = match_with([(1000, 0), (2000, 0), (3000, 1), (58_000, 1), (59_500, 0)])
    (one,) = of_kind("finish", close)
    assert (one.start_ms, one.decisive_ms) == (54_500, 59_500)
    assert one.end_ms > 60_000  # the last picture stays
    assert one.event == "ann 3, bob 2 at the end"
    tie = of_kind("finish", match_with([(1000, 0), (2000, 1)]))[0]
    assert tie.score == 1.0 > one.score
    assert "share" in tie.reason
    assert of_kind("finish", match_with([(1000 * k, 0) for k in range(1, 4)])) == []


def test_an_upset_is_a_win_over_who_won_more_of_the_other_matches():
    upset = match_with([(1000, 1), (2000, 0), (3000, 0)])
    rates = {"ann": 0.1, "bob": 0.8, "cy": 0.3}
    (one,) = of_kind("upset", upset, rates)
    assert one.event == "ann beats bob, 2 : 1"
    assert "10 %" in one.reason
    assert "80 %" in one.reason
    assert one.score == pytest.approx(0.7)
    assert one.decisive_ms == 3000  # from here on it leads
    assert of_kind("upset", upset, {"ann": 0.9, "bob": 0.8, "cy": 0.3}) == []
    assert of_kind("upset", upset, {"bob": 0.8, "cy": 0.3}) == []  # nothing is known of ann
    assert of_kind("upset", match_with([(1000, 0), (2000, 1)]), rates) == []  # nobody wins alone


def test_rates_leave_the_match_itself_out_and_share_ties():
    won_by_ann, tie = match_with([(1000, 0)]), match_with([(1000, 0), (2000, 1)])
    assert win_rates([won_by_ann, won_by_ann, tie])[1] == {"ann": 0.75, "bob": 0.25, "cy": 0.0}
    assert win_rates([won_by_ann, tie]) == [{}, {}]  # one other match is no record


def at(kind, decisive_ms, score) -> Highlight:
    return Highlight(kind, decisive_ms - 1000, decisive_ms, decisive_ms + 1000, score, "", "", "")


def test_the_best_do_not_overlap_and_the_best_of_all_is_last():
    one = [at("lead", 5000, 0.9), at("streak", 6000, 0.8), at("lead", 9000, 0.2)]
    chosen = select_highlights({"a": one, "b": [at("streak", 6000, 0.7)]}, 9)
    assert [(place, highlight.score) for place, highlight in chosen] == [("a", 0.2), ("b", 0.7), ("a", 0.9)]


def test_a_kind_that_was_shown_counts_less():
    highlights = [at("lead", 9000 * k, 0.9) for k in range(1, 4)] + [at("contest", 40_000, 0.7)]
    kinds = [highlight.kind for _, highlight in select_highlights({"a": highlights}, 3)]
    assert kinds == ["lead", "contest", "lead"]
    assert REPEAT_FACTOR < 1


def test_the_events_of_a_real_match_are_what_was_played(play):
    replay = play("duel", chase=True, time_limit_s=30.0, reach_m=1.0, initial_targets=8, spawn_frequency_hz=2.0)
    match = explain(replay)
    assert sum(match.scores) == len(match.catches)
    assert match.catches[-1].scores == match.scores
    assert all(0.0 <= one.score <= 1.0 and one.start_ms < one.end_ms for one in find_highlights(match))
    assert of_kind("contest", match)


def test_prey_that_is_caught_is_worth_the_more_the_longer_it_had_got_away():
    captures = [Capture(0, 51, 5000, 1, "target_turtle_1", 212_345, 5000, 7100, "target_turtle_9")]
    captures.append(Capture(0, 401, 40_000, 2, "target_turtle_9", None, 30_000))
    one, other = of_kind("capture", match_with(captures=captures))
    assert (one.event, one.decisive_ms) == ("bob catches pip (prey_0)", 5000)
    assert one.reason == "The prey had escaped for 5.0 s, from 0.212345 m"
    assert other.event == "cy catches pip (prey_0)"
    assert other.reason == "The prey had escaped for 30.0 s"
    assert other.score == 0.5 > one.score


def test_a_contest_among_team_mates_is_no_highlight():
    claims = (Claim(1, Verdict.GRANTED, 120_000), Claim(0, Verdict.LOST_CONTEST, 120_050, mate=True))
    assert not of_kind("contest", match_with(contests=[replace(contest(50), claims=claims)]))


def test_highlights_of_a_match_with_teams_are_those_of_its_teams(hunted):
    match = explain(hunted)
    *_, last = hunted.worlds()
    assert match.contenders == dict(zip(("a", "b + c"), last.team_scores, strict=True))
    assert match.entrants == ("a", "b + c")
    assert match.catches[-1].scores == last.team_scores
    assert len(match.captures) == sum(prey.times_caught for prey in last.prey)
    assert {one.kind for one in find_highlights(match)} >= {"capture"}
