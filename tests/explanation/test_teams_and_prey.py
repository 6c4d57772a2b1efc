"""`explain` tells of teams and prey: team scores, team-mates in contests, and catches of prey."""

import re

import pytest
from command_line import run

from catch_arena import Verdict, explain, explain_step
from catch_arena.errors import ConfigError
from catch_arena.render.video import render_replay


@pytest.fixture(scope="module")
def mates(play):
    """Two team-mates and a rival at one place, all of whom can catch any target: each contest is theirs."""
    poses = ((5.0, 5.0, 0.0), (5.1, 5.0, 0.0), (5.2, 5.0, 0.0))
    names = ("ann", "ann", "bob")
    settings = {"hunters": 3, "hunter_poses": poses, "teams": ((0, 1), (2,)), "reach_m": 9.0, "initial_targets": 1}
    return play(**settings, max_cycles=1, chase=True, seed=4, names=names)


def test_the_words_name_the_team_mate_and_the_clause(mates):
    explanation = explain(mates)
    lines = [line for line in explanation.lines() if "LOST_CONTEST" in line]
    (contest,) = explanation.contests
    winner, rival, mate = contest.claims  # the rival first, though the team-mate was nearer
    assert (mate.seat, mate.mate, rival.mate) == (1, True, False)
    assert mate.distance_um < rival.distance_um == winner.distance_um + contest.margin_um
    seat = mate.seat
    assert f"LOST_CONTEST (R5.6): bob and ann (hunter_{seat}) (a team-mate, R11.3)" in "\n".join(lines)
    summary = next(line for line in explanation.lines() if line.startswith(f"ann (hunter_{seat}): "))
    assert ", 1 to its own team-mates (R11.3)" in summary
    assert explain_step(mates, 1, seat).lines()[-1] in lines


def test_a_team_mate_with_which_the_winner_drew_a_lot_comes_before_a_farther_rival(play):
    """R5.5: the lot decided, and no margin to the rival."""
    poses = ((5.0, 5.0, 0.0), (5.0, 5.0, 0.0), (5.2, 5.0, 0.0))
    settings = {"hunters": 3, "hunter_poses": poses, "teams": ((0, 1), (2,)), "reach_m": 9.0, "initial_targets": 1}
    matches = [play(**settings, max_cycles=1, chase=True, seed=seed) for seed in range(8)]
    found = [contest for match in matches for contest in explain(match).contests if contest.claims[0].seat < 2]
    assert len(found) > 1
    for contest in found:
        _, second, last = contest.claims
        assert (contest.clause, second.mate, last.seat, contest.margin_um) == ("R5.5", True, 2, 0)
        assert not contest.between_teams


def test_the_words_name_all_hunters_that_a_catch_needed(play):
    """R5.10: the partners of the winner are named, and the reason for which a hunter without one was refused."""
    poses = ((5.0, 5.0, 0.0), (5.1, 5.0, 0.0), (5.2, 5.0, 0.0), (5.3, 5.0, 0.0))
    settings = {"hunters": 4, "hunter_poses": poses, "teams": ((0, 1, 2), (3,)), "reach_m": 9.0, "initial_targets": 1}
    match = play(**settings, hunters_per_catch=2, max_cycles=1, chase=True, seed=4, names=("ann", "bea", "cid", "dan"))
    explanation = explain(match)
    assert ". A catch needs 2 hunters of one team (R5.10). Teams" in explanation.lines()[0]
    (contest,) = explanation.contests
    winner, *partners = (claim.seat for claim in contest.claims)
    names = ("ann", "bea", "cid")
    assert sorted((winner, *partners)) == [0, 1, 2]
    first, second = (names[seat] for seat in partners)
    reason = (
        f"{names[winner]} catches it. LOST_CONTEST (R5.6): {first} (a team-mate, R11.3) and {second} "
        "(a team-mate, R11.3)."
    )
    assert any(line.endswith(reason) for line in explanation.lines())
    waits = "WAITING_FOR_PARTNER, too few hunters of its team asked for the target in this step (R5.10)"
    assert any(line.startswith("At 0.0 s (step 1) dan asked for ") and waits in line for line in explanation.lines())
    assert explanation.to_dict()["hunters_per_catch"] == 2
    (line,) = (line for line in explain_step(match, 1, 3).lines() if line.startswith("dan (hunter_3), "))
    assert waits in line
    assert any(line.endswith(reason) for line in explain_step(match, 1).lines())


def test_contests_and_refusals_name_the_prey_that_was_asked_for(play):
    poses = ((5.0, 5.0, 0.0), (5.1, 5.0, 0.0), (1.0, 1.0, 0.0))
    settings = {"hunter_poses": poses, "reach_m": (9.0, 9.0, 0.1), "max_cycles": 1}
    match = play("tag", **settings, control="target", chase=True)
    explanation = explain(match)
    assert explanation.prey_by_target == {"target_turtle_1": "prey_0"}
    assert any(" asked for target_turtle_1, played by prey_0. " in line for line in explanation.lines())
    assert any(" asked for target_turtle_1, played by prey_0. " in line for line in explain_step(match, 1).lines())
    refused = explain(play("tag", **settings, control=("target", "target", "full"))).lines()
    assert any(" hunter_2 asked for target_turtle_1, played by prey_0 from " in line for line in refused)


def test_the_teams_are_told_with_their_scores_the_best_first(hunted):
    explanation = explain(hunted)
    *_, last = hunted.worlds()
    assert tuple(team.score for team in explanation.teams) == last.team_scores
    assert [team.name for team in explanation.teams] == ["a", "b + c"]
    first, second = sorted(explanation.teams, key=lambda team: -team.score)
    assert (
        f"Teams (R11.1): {first.name} {first.score} and {second.name} {second.score}. Catches: a (hunter_0) "
        in (explanation.lines()[0])
    )


def test_without_teams_nothing_is_told_of_any(mixed):
    explanation = explain(mixed)
    assert explanation.teams == ()
    assert explanation.prey == ()
    assert not any("team" in line or "prey" in line for line in explanation.lines())


@pytest.mark.parametrize("which", ["hunted", "hunted_once"])
def test_every_catch_of_prey_is_told_with_who_from_where_and_when_it_returned(which, request):
    """Beside the worlds: how often each was caught, by whom, and as which target it came back."""
    match = request.getfixturevalue(which)
    explanation = explain(match)
    worlds = list(match.worlds())
    assert [one.times_caught for one in explanation.prey] == [prey.times_caught for prey in worlds[-1].prey]
    assert len(explanation.captures) == sum(one.times_caught for one in explanation.prey) > 0
    for capture in explanation.captures:
        before, after = worlds[capture.step - 1], worlds[capture.step]
        assert before.prey[capture.prey].target == capture.target
        ruling = next(one for one in after.rulings if one.target == capture.target and one.success)
        assert (ruling.hunter, ruling.distance_um) == (capture.seat, capture.distance_um)
        spawned = next(one.spawned_ms for one in before.targets if one.name == capture.target)
        assert capture.in_play_ms == before.time_ms - spawned
        lasting = [world for world in worlds[capture.step :] if world.prey[capture.prey].target is not None]
        back = lasting[0] if lasting else None
        assert capture.returned_ms == (None if back is None else back.time_ms)
        assert capture.returned_as == (None if back is None else back.prey[capture.prey].target)
    assert [one.out for one in explanation.prey] == [prey.target is None for prey in worlds[-1].prey]


def test_catches_of_prey_in_words(hunted):
    explanation = explain(hunted)
    text = "\n".join(explanation.lines())
    assert re.search(
        r"^At \S+ s \(step \d+\) (a \(hunter_[02]\)|b|c) caught target_turtle_\d+, played by [pq] \(prey_\d\), "
        r"from 0\.\d{6} m, after \S+ s in play; it returned at \S+ s as target_turtle_\d+ \(R12\.3\)\.$",
        text,
        re.MULTILINE,
    )
    one = explanation.prey[1]
    assert one.withdrawn_ms == 9000
    expected = f"q (prey_1): caught {one.times_caught} time{'s' * (one.times_caught != 1)}; "
    assert any(line.startswith(expected) and "withdrawn at 9.0 s (R12.5)" in line for line in explanation.lines())


def test_one_hunter_alone_hears_of_its_own_catches(hunted):
    whole, own = explain(hunted), explain(hunted, 1)
    assert [one for one in whole.captures if one.seat == 1] == list(own.captures)
    assert own.prey == ()


def test_a_teams_name_means_all_its_seats(hunted):
    """A team is named by its only agent, or by all its members."""
    for name, seats in (("a", [0, 2]), ("b + c", [1, 3])):
        explanation = explain(hunted, name)
        assert [record.seat for record in explanation.records] == seats
        assert {run.seat for run in explanation.refusals} <= set(seats)
        assert [one.seat for one in explain_step(hunted, 1, name).hunters] == seats


def test_prey_alone_hears_of_its_own_catches(hunted):
    """By what PettingZoo calls it, or by its agent's name, which all its prey have."""
    whole, own = explain(hunted), explain(hunted, "prey_0")
    assert own.captures == tuple(one for one in whole.captures if one.prey == 0) != ()
    assert own.prey == whole.prey[:1]
    assert own.records == ()
    theirs = {target for target, name in whole.prey_by_target.items() if name == whole.prey_names[0]}
    assert own.contests == tuple(one for one in whole.contests if one.target in theirs)
    assert {run.target for run in own.refusals} <= theirs
    name = hunted.prey_names[0]
    same = [index for index, other in enumerate(hunted.prey_names) if other == name]
    assert [one.index for one in explain(hunted, name).prey] == same
    step = explain_step(hunted, own.captures[0].step, "prey_0")
    assert (step.hunters, [one.index for one in step.prey], list(step.distances_um)) == (
        (),
        [0],
        [own.captures[0].target],
    )


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("b", "view_of needs a match that limits or blurs"),
        ("a", "view_of must mean one hunter, got 'a', which means the seats 0, 2"),
        ("prey_0", "view_of must mean one hunter, got 'prey_0', which means prey"),
    ],
)
def test_a_view_is_that_of_one_hunter(hunted, tmp_path, name, error):
    """Prey sees everything."""
    with pytest.raises(ConfigError, match=error):
        render_replay(hunted, tmp_path / "v.gif", view_of=name)


def test_a_step_tells_what_prey_did_and_what_became_of_it(hunted):
    explanation = explain(hunted)
    capture = next(one for one in explanation.captures if one.returned_ms is not None)
    one = explain_step(hunted, capture.step).prey[capture.prey]
    assert (one.caught_by, one.target, one.returned_as) == (capture.seat, capture.target, None)
    assert one.action == hunted.action(capture.step - 1, hunted.config.hunters + capture.prey)
    lines = explain_step(hunted, capture.step).lines()
    name = explanation.prey_names[capture.prey]
    (line,) = (line for line in lines if line.startswith(f"{name}: "))
    assert line.endswith(f", as {capture.target}. It was caught by {explanation.names[capture.seat]} (R12.3).")
    assert any(line.startswith(f"Distances to {capture.target}, played by {name}: ") for line in lines)
    out = explain_step(hunted, capture.step + 1).lines()
    assert f"{name}: out (R12.3)." in out
    back = explain_step(hunted, capture.returned_ms // 100).lines()
    assert f"{name}: out (R12.3). It returned as {capture.returned_as}." in back
    gone = explain_step(hunted, 91).lines()
    assert any(line.startswith("q (prey_1): withdrawn (R12.5).") for line in gone)


def test_the_command_prints_teams_and_prey_as_words_and_as_facts(hunted, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    path = tmp_path / "hunted.replay"
    hunted.save(path)
    words = run("explain", str(path))
    assert words.exit_code == 0, words.output
    assert "(R11.1): a 9 and b + c 2. Catches: " in " ".join(words.output.split())
    facts = explain(hunted).to_dict()
    assert {"teams", "captures", "prey"} <= facts.keys()
    step = explain_step(hunted, 1).to_dict()
    assert [one["target"] for one in step["prey"]] == ["target_turtle_1", "target_turtle_2", "target_turtle_3"]
    assert Verdict.GRANTED.name in {claim["verdict"] for one in facts["contests"] for claim in one["claims"]}
