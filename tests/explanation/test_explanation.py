"""`explain` gives the facts that the arbiter and the oracle give, in words with their clauses."""

import copy
import json
import math
import re
from collections import Counter
from functools import partial

import numpy as np
import pytest
from oracle.arithmetic import SERVICE_LOT, TIE_LOT, draw, key

from catch_arena import ArenaService, Verdict, arbitrate, explain, explain_step
from catch_arena.errors import ConfigError
from catch_arena.explanation import step_at
from catch_arena.explanation.contests import unseen_targets
from catch_arena.messages import CatchTurtleRequest

TIED = ((5.0, 5.0, 0.0), (5.2, 5.0, 0.0), (5.0, 5.0, 0.0))
CLOSE = {"hunters": 3, "hunter_poses": TIED, "initial_targets": 3, "reach_m": 3.0, "max_cycles": 20}


@pytest.fixture(scope="module")
def crowded(play):
    """Much happens: contests of four, outages, refused kills, ranks without a target."""
    return play("faulty", seed=2, chase=True, reach_m=2.0, time_limit_s=30.0, names=("ann", "bob", "cid", "dan"))


def test_every_contest_is_what_the_arbiter_decides(crowded):
    """Each one's claimants, placed as they were, are judged again."""
    worlds = list(crowded.worlds())
    contests = explain(crowded).contests
    assert len(contests) > 10
    for contest in contests:
        before = worlds[contest.step - 1]
        target = next(target for target in before.targets if target.name == contest.target)
        rulings = arbitrate(
            hunters=[(hunter.x, hunter.y) for hunter in before.hunters],
            targets={target.name: (target.x, target.y)},
            requests=[(claim.seat, target.name) for claim in contest.claims],
            reach_m=2.0,
        )
        winner, *losers = contest.claims
        for ruling, claim in zip(rulings, contest.claims, strict=True):
            assert ruling.distance_um == claim.distance_um
            assert ruling.winner == winner.seat
        assert winner.verdict in (Verdict.GRANTED, Verdict.KILL_FAILED)
        assert {claim.verdict for claim in losers} == {Verdict.LOST_CONTEST}
        assert (contest.clause, contest.judged_ms) == ("R5.4", before.time_ms)


def test_targets_lost_without_a_contest_are_in_the_summary(play):
    explanation = explain(play("duel", chase=True, max_cycles=300))
    first = max(explanation.records, key=lambda record: record.forestalled)
    assert first.forestalled > 1
    assert any(
        f"others caught {first.forestalled} targets that it was driving to" in line for line in explanation.lines()
    )


def test_the_summary_adds_up(crowded):
    """Every request of the match stands in it once."""
    rulings = [ruling for world in crowded.worlds() for ruling in world.rulings]
    explanation = explain(crowded)
    for record in explanation.records:
        own = Counter(ruling.verdict for ruling in rulings if ruling.hunter == record.seat)
        assert record.catches == explanation.scores[record.seat] == own.pop(Verdict.GRANTED, 0)
        assert record.contests_lost == own.pop(Verdict.LOST_CONTEST, 0)
        assert record.refused == {verdict.name: count for verdict, count in own.items()}
        assert record.contests_won == sum(contest.claims[0].seat == record.seat for contest in explanation.contests)
    assert all(run.times > 0 for run in explanation.refusals)


def test_a_contest_is_told_with_clause_distances_and_winner(play):
    """Three hunters, two of them equally far and behind."""
    paragraphs = explain(play(chase=True, names=("ann", "bob", "cid"), **CLOSE), "bob").lines()

    assert (
        "At 0.0 s (step 1) bob, ann and cid asked for target_turtle_2. bob was 0.854333 m away; ann was 1.053799 m "
        "away, 0.199466 m farther; cid was 1.053799 m away, 0.199466 m farther. The smaller distance decides (R5.4): "
        "bob catches it. LOST_CONTEST (R5.6): ann and cid."
    ) in paragraphs


def test_an_exact_tie_tells_the_lots_of_the_tied(play):
    """R5.5, as the appendix draws them; the lowest wins."""
    match = play(chase=True, **CLOSE)
    tie = next(contest for contest in explain(match).contests if contest.clause == "R5.5")
    number = int(tie.target.removeprefix("target_turtle_"))
    tied = [claim for claim in tie.claims if claim.lot is not None]
    assert len(tied) == 2
    for claim in tied:
        assert claim.lot == draw(draw(draw(key(match.seed, TIE_LOT), tie.step - 1), number), claim.seat)
    assert tied[0].lot < tied[1].lot
    assert tied[0].verdict is Verdict.GRANTED
    (line,) = [line for line in explain(match).lines() if "so the lowest lot decides (R5.5): " in line]
    assert all(f" away, lot {claim.lot:016x}" in line.replace("the same distance, ", "") for claim in tied)
    assert "the same distance" in line
    (fact,) = [fact for fact in explain(match).to_dict()["contests"] if fact["step"] == tie.step]
    assert [claim["lot"] for claim in fact["claims"] if claim["lot"]] == [f"{claim.lot:016x}" for claim in tied]


def test_first_come_tells_the_lots_of_the_step(play):
    """R5.9."""
    match = play(chase=True, policy="first_come", **CLOSE)
    explanation = explain(match)
    assert "Contests go to the hunter with the lowest lot of the step (R5.9). Catches: " in explanation.lines()[0]
    contests = explanation.contests
    assert contests
    for contest in contests:
        lots = [draw(draw(key(match.seed, SERVICE_LOT), contest.step - 1), claim.seat) for claim in contest.claims]
        assert [claim.lot for claim in contest.claims] == lots
        assert lots[0] == min(lots)
    assert any("The lowest lot of the step decides (R5.9): " in line for line in explanation.lines())


def test_the_capstones_service_is_said_to_refuse_nobody(play):
    """R9.1: nobody won, and nobody lost."""
    explanation = explain(play(chase=True, policy="capstone", **CLOSE))
    assert "The capstone's service grants every request (R9.1). Catches: " in explanation.lines()[0]
    assert {contest.clause for contest in explanation.contests} == {"R9.1"}
    assert any("grants each of them, GRANTED (R9.1)" in line for line in explanation.lines())
    assert {(record.contests_won, record.contests_lost) for record in explanation.records} == {(0, 0)}


def test_repeated_refusals_are_one_line_with_a_count(play):
    match = play(
        "duel", hunters=1, control="full", initial_targets=1, spawn_frequency_hz=0, max_cycles=30, reach_m=1e-6
    )
    lines = explain(match).lines()
    (refused,) = [line for line in lines if "OUT_OF_REACH, " in line]
    times = sum(ruling.verdict is Verdict.OUT_OF_REACH for world in match.worlds() for ruling in world.rulings)
    assert refused.startswith("At 0.3 s (step 4) hunter_0 asked ")
    assert f" {times} times until 2.9 s (step 30) for target_turtle_1 from " in refused
    assert refused.endswith("the target is out of reach (R5.3); within reach is less than 0.000001 m.")
    assert "No contest." in lines


def test_requests_by_name_are_one_line_for_each_name():
    """A node asks for two targets that never were, in every step."""
    service = ArenaService("duel", control_period_ms=16, time_limit_s=1)
    service.record(("a", "b"))
    service.reset(1)
    while not service.over:
        service.step(requests=[("hunter_0", CatchTurtleRequest(f"turtle{k}")) for k in range(2)])
    explanation, steps = explain(service.replay), service.world.step
    assert [(run.target, run.verdict, run.times) for run in explanation.refusals] == [
        ("turtle0", Verdict.UNKNOWN_TARGET, steps),
        ("turtle1", Verdict.DUPLICATE, steps),
    ]
    assert any(
        f" a asked {steps} times until " in line and '"turtle1": DUPLICATE' in line for line in explanation.lines()
    )


def test_what_was_asked_for_by_name_is_told_with_its_verdict(named):
    """Each is a refusal with its reason, in the match and in its step; control characters are not printed."""
    explanation = explain(named)
    verdicts = Counter(one.verdict.name for _, _, by_name in named.judged_steps() for one in by_name)
    assert sum(record.refused.get("DUPLICATE", 0) for record in explanation.records) == verdicts["DUPLICATE"] > 0
    assert all(line.isprintable() for line in explanation.lines())
    assert any(
        'for "x": UNKNOWN_TARGET, no such target was ever spawned (R5.2)' in line for line in explanation.lines()
    )
    step, seat, _ = next(one for one in named.named_requests if one.name == "x")
    (action,) = explain_step(named, step + 1, seat).hunters
    assert [one.target for one in action.by_name] == [
        name for at, who, name in named.named_requests if (at, who) == (step, seat)
    ]
    text = " ".join(explain_step(named, step + 1, seat).lines())
    assert '"x": ' in text
    both = copy.deepcopy(named)
    both.choices[step][seat] = 1
    assert both.action(step, seat).endswith(", rank 1")
    assert "It requested nothing" not in text


def test_every_refusal_has_its_reason_and_clause(play):
    """Outages, refused kills, empty ranks, a withdrawn hunter: each verdict that occurs is told with its clause."""
    match = play("faulty", seed=5, control="full", reach_m=3.0, max_cycles=200, withdraw={50: ["hunter_1"]})
    explanation = explain(match)
    clauses = {
        "SERVICE_DOWN": "R5.7",
        "KILL_FAILED": "R5.7",
        "MALFORMED": "R5.2",
        "OUT_OF_REACH": "R5.3",
        "HUNTER_INACTIVE": "R1.6",
    }
    assert {run.verdict.name for run in explanation.refusals} == clauses.keys()
    for verdict, clause in clauses.items():
        assert any(re.search(rf"{verdict}, .*\({clause}\)", line) for line in explanation.lines())
    assert explanation.records[1].withdrawn_ms == 5000
    assert explanation.lines()[-3].endswith("withdrawn (R1.6) at 5.0 s.")


def test_one_hunter_alone_is_named_by_seat_or_by_name(crowded):
    """The other ones are heard of where they contest."""
    explanation = explain(crowded, "cid")
    assert explanation == explain(crowded, 2) == explain(crowded, "2") == explain(crowded, "hunter_2")
    assert [record.seat for record in explanation.records] == [2]
    assert {run.seat for run in explanation.refusals} == {2}
    assert all(2 in [claim.seat for claim in contest.claims] for contest in explanation.contests)
    assert 0 < len(explanation.contests) < len(explain(crowded).contests)
    for wrong, error in (
        (7, "a seat from 0 to 3, got 7"),
        (-1, "got -1"),
        ("bbo", "did you mean bob"),
        ("", "known: ann, bob"),
        (1.5, r"^hunter must be a seat from 0 to 3, got 1\.5$"),
    ):
        with pytest.raises(ConfigError, match=error):
            explain(crowded, wrong)


def test_agents_of_one_name_are_told_apart_by_their_seats(play):
    """The name alone means both agents."""
    match = play("duel", max_cycles=2, names=("ann", "ann"))
    assert explain(match).names == ("ann (hunter_0)", "ann (hunter_1)")
    assert explain(match, "ann") == explain(match)


def test_a_step_is_told_whole(crowded):
    """Actions, requests, verdicts, and everybody's distance to what was asked for."""
    contest = explain(crowded).contests[0]
    explained = explain_step(crowded, contest.step)
    before, after = list(crowded.worlds())[contest.step - 1 : contest.step + 1]
    assert (explained.begin_ms, explained.end_ms) == (before.time_ms, after.time_ms)
    assert explained.contests == (contest,)
    assert [one.action for one in explained.hunters] == [crowded.action(contest.step - 1, seat) for seat in range(4)]
    by_seat = {ruling.hunter: ruling for ruling in after.rulings}
    for one in explained.hunters:
        ruling = by_seat.get(one.seat)
        assert one.ruling == ruling
        assert one.chosen == after.hunters[one.seat].active_target
    target = next(target for target in before.targets if target.name == contest.target)
    for hunter, distance in zip(before.hunters, explained.distances_um[contest.target], strict=True):
        assert distance == round(1e6 * ((hunter.x - target.x) ** 2 + (hunter.y - target.y) ** 2) ** 0.5)
    assert len(explain_step(crowded, contest.step, "bob").hunters) == 1


def test_a_step_is_found_by_the_time_at_which_it_was_judged(crowded, play):
    """Or by any time until the next one."""
    for contest in explain(crowded).contests:
        assert step_at(crowded, contest.judged_ms / 1000) == contest.step
    assert [step_at(crowded, at) for at in (0, 0.05, 12.3, 12.399, 12.4, 29.9)] == [1, 1, 124, 124, 125, 300]
    for at in (-0.1, 30.0, math.nan, math.inf):
        with pytest.raises(ConfigError, match=r"at must be from 0 to 29\.9 s, when the last step is judged, got"):
            step_at(crowded, at)
    assert step_at(play("duel", control_period_ms=134, max_cycles=9), 8 * 0.134) == 9


def test_the_seat_of_every_hunter_is_told_where_there_are_copies(play):
    """nearest#2 is not hunter_2."""
    paragraphs = explain(play("duel", max_cycles=20, names=("nearest#2", "nearest"))).lines()
    rule = r"Contests go to the nearest hunter \(R5\.4\)\."
    assert re.search(rule + r" Catches: nearest#2 \(hunter_0\) \d+ and nearest \(hunter_1\) \d+\.$", paragraphs[0])
    assert [line.split(":")[0] for line in paragraphs[-2:]] == ["nearest#2 (hunter_0)", "nearest (hunter_1)"]


def test_a_step_that_is_not_there_is_refused(crowded):
    """Steps count from 1."""
    for step in (0, 301, -1):
        with pytest.raises(ConfigError, match=f"step must be a whole number from 1 to 300, got {step}"):
            explain_step(crowded, step)
    assert explain_step(crowded, np.int64(3)) == explain_step(crowded, 3)


def test_explain_prints_paragraphs_of_80_columns(crowded, catch_arena):
    """Wrong arguments are one line and exit code 2."""
    crowded.save("m.replay")
    call = partial(catch_arena, "explain", "m.replay")
    whole, one, step = call(), call("--hunter", "bob"), call("--step", "62", "--hunter", "ann")
    for result in (whole, one, step):
        assert result.exit_code == 0, result.output
        assert max(map(len, result.stdout.splitlines())) <= 80
    assert len(one.stdout) < len(whole.stdout)
    facts = explain_step(crowded, explain(crowded).contests[0].step).to_dict()
    assert json.loads(json.dumps(facts)) == facts
    assert {"hunters", "prey_by_target", "prey"} < facts.keys()
    verdicts = [one["ruling"]["verdict"] for one in facts["hunters"] if one["ruling"] is not None]
    assert verdicts
    assert set(verdicts) <= {verdict.name for verdict in Verdict}
    assert call("--at", "6.1", "--hunter", "ann").stdout == step.stdout
    for words in (
        ["--hunter", "bbo"],
        ["--step", "0"],
        ["--hunter", "9"],
        ["--at", "30"],
        ["--at", "1", "--step", "11"],
    ):
        refused = call(*words)
        assert (refused.exit_code, len(refused.stderr.splitlines())) == (2, 1)


# what hunters do not see


@pytest.fixture(scope="module", params=["radius", "cone", "both"])
def half_blind(play, request):
    """Hunters of all three controls, with reaches of their own, that see a part; targets flee, hunters drop out."""
    views = {"radius": {"view_radius_m": 2.5}, "cone": {"view_angle_deg": 100.0}}
    view = views.get(request.param) or {**views["radius"], **views["cone"]}
    return play(
        seed=8,
        chase=False,
        target_motion="flee",
        control=("target", "full", "velocity", "target"),
        reach_m=(0.3, 0.9, 0.5, 1.4),
        dropout_rate=0.004,
        max_cycles=150,
        names=("ann", "bob", "cid", "dan"),
        **view,
    )


def test_what_a_hunter_is_said_to_see_is_what_the_engine_ranks(half_blind):
    """In every state each seat has ranks for the nearest targets in sight, and none for those called unseen."""
    hidden = 0
    for engine in half_blind.engines():
        world = engine.world()
        for seat in range(4):
            view = {half_blind.config.target_name(number) for number in engine.numbers_seen(seat)[0] if number}
            unseen = {one.target for one in unseen_targets(half_blind.config, world, seat)}
            seen = {target.name for target in world.targets} - unseen
            assert view <= seen
            hidden += len(unseen)
            assert len(view) == min(8, len(seen))
    assert hidden > 100


def test_a_step_says_what_was_out_of_sight(play):
    """In words: one too far, one behind, and whose nearest it was."""
    poses = ((2.0, 5.0, 0.0), (9.0, 5.0, 0.0))
    match = play("duel", hunter_poses=poses, seed=2, max_cycles=2, chase=True, view_radius_m=4.0, view_angle_deg=120.0)
    step = explain_step(match, 1)
    text = " ".join(step.lines())
    assert "It sees targets that are nearer than 4 m and at most 60 degrees off its heading (R7.5): " in text
    for one in step.hunters:
        for other in one.unseen:
            place = f"{other.distance_um / 1e6:.6f} m away and {other.off_heading_deg:.1f} degrees off its heading"
            assert f"{other.target}, {place}" in text
    assert json.loads(json.dumps(step.to_dict()))["hunters"][0]["unseen"][0].keys() == {
        "target",
        "distance_um",
        "off_heading_deg",
    }


def test_where_hunters_see_everything_nothing_is_said_of_sight(crowded):
    step = explain_step(crowded, 62)
    assert not any("sight" in line for line in (*step.lines(), *explain(crowded).lines()))
    assert all(one.unseen == () for one in step.hunters)


def test_a_dropout_is_told_apart_from_a_withdrawal(play):
    """R1.7 and R1.6: in the summary, and in the steps from then on."""
    match = play("dropout", dropout_rate=0.02, seed=3, max_cycles=60, withdraw={1: ["hunter_2"]})
    explanation = explain(match)
    worlds = list(match.worlds())
    out = {}
    for world in worlds:
        for seat, hunter in enumerate(world.hunters):
            if hunter.withdrawn:
                out.setdefault(seat, world)
    assert len(out) > 1
    assert (explanation.records[2].withdrawn_ms, explanation.records[2].out) == (100, "withdrawn (R1.6)")
    for seat, world in out.items():
        record = explanation.records[seat]
        cause = "withdrawn (R1.6)" if seat == 2 else "dropped out (R1.7)"
        assert (record.withdrawn_ms, record.out) == (world.time_ms - 100, cause)
        (line,) = [line for line in explanation.lines() if line.startswith(f"hunter_{seat}: ")]
        assert line.endswith(f"{cause} at {(world.time_ms - 100) / 1000:.1f} s.")
        explained = explain_step(match, world.step, seat)
        assert explained.hunters[0].out == cause
        assert f"It takes no part: {cause}." in " ".join(explained.lines())
        assert explain_step(match, world.step - 1, seat).hunters[0].out is None
