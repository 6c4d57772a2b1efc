"""`what_if` finds actions with which a hunter wins a contest that it lost, and the engine agrees."""

import re

import pytest
from typer.testing import CliRunner

from catch_arena import Engine, Ruling, Verdict, explain, what_if
from catch_arena.cli import main
from catch_arena.errors import ConfigError
from catch_arena.explanation import Contest, WhatIf, lost_contest_at
from catch_arena.replay import Replay
from catch_arena.replay.comparison import verify

WINDOW_MS = 2000
FIRST_STEP = {"hunters": 2, "hunter_poses": ((5.0, 5.0, 0.0), (5.0, 5.0, 0.0)), "initial_targets": 3, "reach_m": 9.0}
"""Settings in which a contest is judged on the first state."""
MATCHES = {
    "chase": {"seed": 1, "chase": True, "max_cycles": 300},
    "wide reach": {"seed": 2, "chase": True, "max_cycles": 200, "reach_m": 0.8},
    "velocity": {"seed": 3, "control": "velocity", "hunters": 8, "reach_m": 2.5, "reverse": True, "max_cycles": 80},
    "full": {"seed": 3, "control": "full", "hunters": 8, "reach_m": 2.5, "max_cycles": 100},
    "short steps": {"seed": 2, "chase": True, "control_period_ms": 40, "time_limit_s": 20.0, "reach_m": 0.8},
    "flee": {"seed": 6, "chase": True, "target_motion": "flee", "reach_m": 0.9, "max_cycles": 150},
    "lots": {"seed": 2, "chase": True, "policy": "first_come", "reach_m": 1.0, "max_cycles": 200},
    "faulty": {"scenario": "faulty", "seed": 2, "chase": True, "reach_m": 1.5, "max_cycles": 150},
}
ANSWERS = {
    "chase": 4,
    "wide reach": 4,
    "velocity": 2,
    "full": 2,
    "short steps": 1,
    "flee": 3,
    "lots": 2,
    "faulty": 2,
}
"""Number of the first four lost contests of each match that have an answer, 20 in all."""


def lost(replay: Replay) -> list[Contest]:
    return [
        contest
        for contest in explain(replay).contests
        if any(claim.verdict is Verdict.LOST_CONTEST for claim in contest.claims)
    ]


def play_again(replay: Replay, seat: int, actions: dict, steps: int) -> Engine:
    """The engine after these steps of a match, in which one hunter's actions are replaced."""
    engine = Engine(replay.config)
    engine.reset([replay.seed])
    for step in range(steps):
        for agent in replay.withdrawn_before(step):
            engine.withdraw(0, agent)
        choices = replay.choices[step].copy()
        commands = replay.commands[step].copy()
        match actions.get(step):
            case int(rank):
                choices[seat] = rank
            case {"cmd_vel": command, "catch": rank}:
                choices[seat], commands[seat] = rank, command
            case (linear, angular):
                commands[seat] = linear, angular
        engine.step(choices[None], commands[None])
    return engine


def rulings_on(engine: Engine, target: str) -> list[Ruling]:
    return [ruling for ruling in engine.world(0).rulings if ruling.target == target]


def check(replay: Replay, contest: Contest, answer: WhatIf) -> None:
    """The engine plays the answer, and the loser wins the target by the margin that was said."""
    assert answer.alternative is not None
    steps, period_ms = answer.alternative.steps, replay.config.control_period_ms
    assert steps <= contest.step
    assert contest.judged_ms - WINDOW_MS <= min(answer.actions) * period_ms
    assert max(answer.actions) < steps
    engine = play_again(replay, answer.seat, answer.actions, steps)
    won = rulings_on(engine, contest.target)
    granted = next(ruling for ruling in won if ruling.success)
    assert granted.hunter == answer.seat
    rivals = [ruling.distance_um for ruling in won if ruling.verdict is Verdict.LOST_CONTEST]
    margin_um = min(rivals) - granted.distance_um if rivals else None
    assert answer.margin_um == margin_um
    assert engine.digest() == answer.alternative.digests[-1]
    assert verify(answer.alternative) == []
    assert contest.target in answer.sentence or "prey_" in answer.sentence
    assert answer.sentence.endswith(".")


@pytest.mark.parametrize(("name", "expected"), ANSWERS.items())
def test_the_engine_plays_each_answer_and_the_loser_wins(play, name, expected):
    """The first four contests of matches of every control and policy; twenty have an answer."""
    match, helpful = play(**MATCHES[name]), 0
    for contest in lost(match)[:4]:
        answer = what_if(match, contest)
        if answer.alternative is not None:
            helpful += 1
            check(match, contest, answer)
        else:
            assert answer.sentence.startswith("No change of ")
            assert (answer.actions, answer.margin_um) == ({}, None)
    assert helpful == expected


def test_prey_may_be_the_target_and_team_mates_the_rivals(hunted):
    answers = [(contest, what_if(hunted, contest)) for contest in lost(hunted)]
    helpful = [(contest, answer) for contest, answer in answers if answer.alternative is not None]
    for contest, answer in helpful:
        check(hunted, contest, answer)
    assert any("catches p (prey_" in answer.sentence or "catches q (prey_" in answer.sentence for _, answer in helpful)


def test_an_earlier_choice_is_no_earlier_than_needed(play):
    """One step later the hunter does not catch the target."""
    replay, found = play(**MATCHES["wide reach"]), 0
    for contest in lost(replay):
        answer = what_if(replay, contest)
        if " earlier: " not in answer.sentence:
            continue
        found += 1
        later = {step: action for step, action in answer.actions.items() if step > min(answer.actions)}
        for steps in range(min(answer.actions) + 1, contest.step + 1):
            rulings = rulings_on(play_again(replay, answer.seat, later, steps), contest.target)
            assert not any(ruling.success and ruling.hunter == answer.seat for ruling in rulings)
    assert found


def test_the_answer_is_always_the_same(play):
    replay = play(**MATCHES["wide reach"])
    contest = lost(replay)[0]
    shown = []
    assert what_if(replay, contest) == what_if(replay, contest, progress=lambda *done: shown.append(done))
    assert shown == sorted(shown)


def test_the_progress_is_that_of_the_steps_to_play(play, monkeypatch):
    """So the time that is left follows from it. Under velocity control every run of steps is tried."""
    replay, played, shown = play(**MATCHES["velocity"]), [], []
    step = Engine.step

    def counted(engine, choices, commands):
        if engine.num_arenas > 1:
            played.append(engine)
        return step(engine, choices, commands)

    monkeypatch.setattr(Engine, "step", counted)
    whole = 0
    for contest in lost(replay):
        played.clear()
        answer = what_if(replay, contest, progress=lambda *progress: shown.append((*progress, len(played))))
        if answer.alternative is None:
            whole += 1
            assert shown[-1][0] == shown[-1][1]
    assert whole
    assert len(shown) > 3
    assert all(done == steps for done, _, steps in shown)


def test_no_change_helps_on_the_first_state(play):
    replay = play(chase=True, max_cycles=3, names=("ann", "bob"), **FIRST_STEP)
    contest = explain(replay).contests[0]
    answer = what_if(replay, contest)
    assert re.fullmatch(
        r"No change of (ann|bob)'s actions within 2 s would have won target_turtle_\d: \d+ were tried\.",
        answer.sentence,
    )
    assert answer.alternative is None


def test_a_contest_is_found_by_its_time_and_loser(play):
    replay = play(**MATCHES["wide reach"], names=("ann", "bob", "cid", "dan"))
    contest = lost(replay)[1]
    assert lost_contest_at(replay, contest.judged_ms / 1000.0 + 0.04) == contest
    loser = replay.names[contest.claims[1].seat]
    assert lost_contest_at(replay, contest.judged_ms / 1000.0, loser) == contest
    assert what_if(replay, contest, loser).seat == contest.claims[1].seat


def test_what_cannot_be_asked_is_one_line(play):
    replay = play(**MATCHES["wide reach"], names=("ann", "bob", "cid", "dan"))
    contest = lost(replay)[0]
    winner = replay.names[contest.claims[0].seat]
    with pytest.raises(ConfigError, match=f"contest must be one that {winner} lost, got the one for {contest.target}"):
        what_if(replay, contest, winner)
    for other in (play(**MATCHES["chase"]), play(max_cycles=5)):
        with pytest.raises(ConfigError, match=r"contest must be one of explain\(replay\)\.contests, got Contest"):
            what_if(other, contest)
    capstone = play("capstone", hunters=2, initial_targets=2, chase=True, max_cycles=20)
    with pytest.raises(ConfigError, match=r"must have a contest that was lost, and it has none$"):
        lost_contest_at(capstone, 1.0)
    with pytest.raises(ConfigError, match=r"at must be from 0 to 19\.9 s, when the last step is judged, got 500 s"):
        lost_contest_at(replay, 500.0)


def test_the_command_says_the_answer(play, tmp_path):
    replay = play(**MATCHES["wide reach"])
    contest = lost(replay)[0]
    replay.save(tmp_path / "a.replay")
    play("duel", max_cycles=5).save(tmp_path / "quiet.replay")

    def call(name: str, *words: str):
        return CliRunner().invoke(main, ["explain", str(tmp_path / name), "--what-if", *words])

    said = call("a.replay", "--at", str(contest.judged_ms / 1000.0))
    assert said.exit_code == 0, said.output
    assert " ".join(said.stdout.split()) == what_if(replay, contest).sentence
    for name, words, error in (
        ("a.replay", (), "--what-if needs --at"),
        ("a.replay", ("--at", "0"), f"got 0 s; the nearest is at {contest.judged_ms / 1000.0:g} s"),
        ("quiet.replay", ("--at", "0.1"), "the match must have a contest that was lost, and it has none"),
    ):
        refused = call(name, *words)
        assert refused.exit_code == 2
        assert error in refused.stderr
        assert len(refused.stderr.splitlines()) == 1
