"""Chapter 1, time: every clause on every adjudicator."""

import pytest
from oracle.arena import PART_NAMES
from rulebook.adjudicators import Adjudicator, ticks_turned
from rulebook.conftest import ArenaFactory

from catch_arena.verdicts import Verdict

TURN = 0.02
"""A turn rate [rad/s], as a share of a limit of 1, so low that headings tell the number of ticks."""


def ticks_of(arena: Adjudicator, steps: int) -> list[int]:
    """Numbers of ticks of the next steps."""
    counts = []
    for _ in range(steps):
        before = arena.hunter().theta
        arena.step((0.0, TURN))
        counts.append(ticks_turned(before, arena.hunter().theta, arena.hunter().w))
    return counts


@pytest.mark.rule("R1.1")
@pytest.mark.parametrize("period", [16, 17, 100, 333])
def test_r1_1_the_clock_counts_whole_milliseconds(arena: ArenaFactory, period: int) -> None:
    """After any number of steps it shows their sum, exactly."""
    match = arena(control_period_ms=period)
    assert match.time == 0
    for step in range(1, 151):
        match.hold()
        assert match.time == step * period
        assert match.steps == step


@pytest.mark.rule("R1.2")
def test_r1_2_a_tick_integrates_16_ms(arena: ArenaFactory) -> None:
    """With a period of 16 ms every step is one tick."""
    match = arena(control="velocity", control_period_ms=16, max_turn_rate_radps=1.0)
    for _ in range(5):
        before = match.hunter().theta
        match.step((0.0, 0.5))
        assert match.hunter().theta - before == pytest.approx(0.5 * 0.016, abs=1e-15)


@pytest.mark.rule("R1.2")
def test_r1_2_ticks_happen_at_the_multiples_of_16_ms(arena: ArenaFactory) -> None:
    """With a period of 17 ms the sixteenth step ends at 272 ms and has the seventeenth tick besides its own."""
    match = arena(control="velocity", control_period_ms=17, max_turn_rate_radps=1.0)
    assert ticks_of(match, 20) == [1] * 15 + [2] + [1] * 4


@pytest.mark.rule("R1.3")
def test_r1_3_a_step_of_100_ms_has_6_or_7_ticks_and_four_have_25(arena: ArenaFactory) -> None:
    """The ticks are those in (t, t + 100]: the one at 400 ms belongs to the fourth step."""
    match = arena(control="velocity", max_turn_rate_radps=1.0)
    assert match.config.control_period_ms == 100
    assert ticks_of(match, 12) == [6, 6, 6, 7] * 3


@pytest.mark.rule("R1.4")
def test_r1_4_requests_are_judged_before_the_motion(arena: ArenaFactory) -> None:
    """The hunter is within reach when it asks and out of reach when the step ends."""
    match = arena(control="full", max_speed_mps=50.0)
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(4.8, 5.0)])
    match.step(((1.0, 0.0), 1))
    assert match.verdicts == [Verdict.GRANTED]
    assert match.hunter().x > 9.0


@pytest.mark.rule("R1.4")
def test_r1_4_a_catch_makes_room_for_a_target_of_the_same_step(arena: ArenaFactory) -> None:
    """Commit comes before spawning: the timer fires in the step in which the only target is caught."""
    match = arena(control="full", max_targets=1, spawn_frequency_hz=10.0)
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(5.1, 5.0)])
    match.step(((0.0, 0.0), 1))
    assert match.verdicts == [Verdict.GRANTED]
    assert match.alive == [2]
    assert match.skipped_full == 0


@pytest.mark.rule("R1.4")
def test_r1_4_what_spawns_within_a_step_is_seen_after_it(arena: ArenaFactory) -> None:
    """The mask shows no rank before, and one after; the age counts from the firing."""
    match = arena(spawn_frequency_hz=1000 / 150, observed_targets=2)
    assert match.mask(0) == [1, 0, 0]
    match.hold()
    assert match.mask(0) == [1, 0, 0]
    match.hold()
    assert match.mask(0) == [1, 1, 0]
    assert match.targets[0].appeared == 150
    assert match.seen_targets()[0]["age"] == pytest.approx(0.050, abs=1e-8)


@pytest.mark.rule("R1.4")
def test_r1_4_the_end_is_tested_after_spawning(arena: ArenaFactory) -> None:
    """The last alive target is caught while the budget's next one appears: the episode goes on."""
    match = arena(control="full", target_budget=2, spawn_frequency_hz=10.0)
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(5.1, 5.0)])
    match.step(((0.0, 0.0), 1))
    assert match.verdicts == [Verdict.GRANTED]
    assert match.spawned == 2
    assert not match.terminated


@pytest.mark.rule("R1.5")
@pytest.mark.parametrize(("limit", "steps"), [(0.25, 3), (0.3, 3), (0.301, 4), (0.05, 1)])
def test_r1_5_an_episode_is_truncated_at_the_first_boundary_at_or_past_its_limit(
    arena: ArenaFactory, limit: float, steps: int
) -> None:
    """No earlier boundary truncates."""
    match = arena(time_limit_s=limit)
    for step in range(1, steps + 1):
        match.hold()
        assert match.truncated == (step == steps)
        assert not match.terminated


@pytest.mark.rule("R1.5")
def test_r1_5_max_cycles_says_the_limit_in_steps(arena: ArenaFactory) -> None:
    """Whatever the time limit says."""
    match = arena(max_cycles=2, time_limit_s=0.1, control_period_ms=70)
    match.hold()
    assert not match.truncated
    match.hold()
    assert match.truncated


@pytest.mark.rule("R1.5")
def test_r1_5_an_episode_terminates_when_its_budget_is_spawned_and_caught(arena: ArenaFactory) -> None:
    """The initial target counts, and so does the one that the timer adds."""
    match = arena(
        control="full", initial_targets=1, max_targets=2, target_budget=2, spawn_frequency_hz=5.0, reach_m=50.0
    )
    match.step(((0.0, 0.0), 1))
    assert match.scores == [1]
    assert match.alive == []
    assert not match.terminated
    match.hold()
    assert match.spawned == 2
    match.hold()
    assert not match.terminated
    match.step(((0.0, 0.0), 1))
    assert match.terminated
    assert not match.truncated
    assert match.scores == [2]


@pytest.mark.rule("R1.5")
def test_r1_5_the_budget_counts_the_targets_that_appeared(arena: ArenaFactory) -> None:
    """Not the numbers: a spawn that the simulator refused is made up for."""
    match = arena(target_budget=6, max_targets=6, spawn_frequency_hz=10.0, faults={"spawn_refused": 0.5})
    match.hold(40)
    assert match.spawned == len(match.alive) == 6
    assert match.used == 6 + match.refused
    assert match.refused > 0


@pytest.mark.rule("R1.5")
def test_r1_5_requests_of_the_last_step_count_and_termination_goes_before_truncation(arena: ArenaFactory) -> None:
    """The last target is caught in the step that reaches the time limit."""
    match = arena(control="full", target_budget=1, time_limit_s=0.2)
    match.place(hunters=[(5.0, 5.0, 0.0)], targets=[(5.1, 5.0)])
    match.hold()
    assert not match.terminated
    match.step(((0.0, 0.0), 1))
    assert match.time == 200
    assert match.verdicts == [Verdict.GRANTED]
    assert match.scores == [1]
    assert match.terminated
    assert not match.truncated


@pytest.mark.rule("R1.6")
def test_r1_6_a_withdrawn_hunter_stands_still(arena: ArenaFactory) -> None:
    """From the withdrawal on its velocity is zero, whatever it commands."""
    match = arena(control="velocity", hunters=2)
    match.step((1.0, 1.0), (1.0, 1.0))
    assert match.hunter(0).v > 0
    match.withdraw(0)
    assert (match.hunter(0).v, match.hunter(0).w, match.hunter(0).withdrawn) == (0.0, 0.0, 1.0)
    before = match.hunter(0)[:3]
    match.step((1.0, 1.0), (1.0, 1.0))
    assert match.hunter(0)[:3] == before
    assert (match.hunter(0).v, match.hunter(0).w) == (0.0, 0.0)
    assert match.hunter(1).v > 0


@pytest.mark.rule("R1.6")
def test_r1_6_the_others_do_not_see_a_withdrawn_hunter(arena: ArenaFactory) -> None:
    """At once, and in the next step; it goes on seeing them."""
    match = arena(control="velocity", hunters=3, max_targets=1, observed_targets=1)
    match.place(hunters=[(5.0, 5.0, 0.0), (6.0, 5.0, 0.0), (8.0, 5.0, 0.0)])
    assert [rival["forward"] for rival in match.seen_rivals()] == [1.0, 3.0]
    match.withdraw(1)
    match.look()
    assert [rival["present"] for rival in match.seen_rivals(1)] == [1.0, 1.0]
    for _ in range(2):
        near, far = match.seen_rivals()
        assert (near["forward"], near["left"], near["present"]) == (3.0, 0.0, 1.0)
        assert set(far.values()) == {0.0}
        match.hold()


@pytest.mark.rule("R1.6")
def test_r1_6_a_withdrawn_hunters_requests_are_hunter_inactive_and_its_rewards_zero(arena: ArenaFactory) -> None:
    """The farther hunter wins the target instead."""
    weights = {"catch": 1.0, "rejected_request": -1.0, "rival_catch": -1.0, "time": -1.0, "progress": 1.0}
    match = arena(control="full", hunters=2, rewards=weights)
    match.place(hunters=[(5.0, 5.0, 0.0), (5.2, 5.0, 0.0)], targets=[(5.0, 5.0)])
    match.withdraw(0)
    match.step(((0.0, 0.0), 1), ((0.0, 0.0), 1))
    assert match.verdicts == [Verdict.HUNTER_INACTIVE, Verdict.GRANTED]
    assert match.rewards[0] == 0.0
    assert match.parts[0] == (0.0,) * len(PART_NAMES)
    assert match.rewards[1] != 0.0
