"""`diff` names the first difference between two replays."""

import copy
import re

import numpy as np
import pytest

from catch_arena.replay.comparison import replay_differences


@pytest.fixture
def pair(mixed):
    """A match, and a copy to be changed."""
    return mixed, copy.deepcopy(mixed)


def test_headers_are_compared_setting_by_setting(play):
    """Seed, title, names, controls and settings, groups by their parts."""
    one = play("duel", max_cycles=2, names=("ann", "bob"), title="final")
    other = play(
        "duel", max_cycles=2, seed=2, names=("ann", "cid"), reach_m=0.5, control=("target", "full"), gains={"ki_v": 0.5}
    )
    found = replay_differences(one, other)

    assert found[:6] == [
        "seed: 1 in A; 2 in B",
        "title: 'final' in A; '' in B",
        "the agent of hunter_1: 'bob' in A; 'cid' in B",
        "control: target in A; ('target', 'full') in B",
        "gains.ki_v: 1.0 in A; 0.5 in B",
        "reach_m: 0.3 in A; 0.5 in B",
    ]
    assert "the states first differ in the initial state" in found
    assert any(re.match(r"the initial state: hunter_1: x is \d\.\d+ in A and ", line) for line in found)


def test_states_of_still_and_of_moving_targets_are_not_compared(play):
    one, other = (play("duel", max_cycles=5, target_motion=motion) for motion in ("still", "flee"))
    assert replay_differences(one, other)[1:] == ["with different targets_move, actions and states cannot be compared"]


def test_the_first_actions_that_differ_are_told_with_who_and_what(pair):
    """A rank, a command's last bit, and a withdrawal."""
    one, other = pair
    other.choices[30][3] = (one.choices[30][3] + 1) % 9
    assert replay_differences(one, other)[0] == (
        f"step 31: hunter_3 acts differently: {one.action(30, 3)} in A; {other.action(30, 3)} in B"
    )
    other.commands[20][1, 0] = np.nextafter(one.commands[20][1, 0], np.float32(0))
    first = replay_differences(one, other)[0]
    assert re.fullmatch(
        r"step 21: hunter_1 acts differently: linear \S+ and angular \S+ of the limits in A; linear .* in B",
        first,
    )
    assert f"{one.commands[20][1, 0]:+.9g}" in first
    assert f"{other.commands[20][1, 0]:+.9g}" in first
    other.withdrawals.insert(0, (10, 0))
    assert replay_differences(one, other)[0] == "before step 11: hunter_0 is withdrawn in B only"


def test_the_first_state_that_differs_is_told_with_its_numbers(play):
    one, other = (
        play("duel", max_cycles=9, chase=True, max_speed_mps=speed, names=("ann", "bob")) for speed in (2.0, 1.5)
    )
    found = replay_differences(one, other)

    assert found[:2] == ["max_speed_mps: 2.0 in A; 1.5 in B", "the states first differ in step 1"]
    assert "step 1: hunter_0 (ann): linear_velocity is 2.0 in A and 1.5 in B" in found
    assert found[-1] == "final scores of the hunters: 0, 0 in A; 0, 0 in B"


def test_a_target_may_have_the_name_of_a_hunter(play):
    one, other = (
        play("duel", max_cycles=9, name_prefix="hunter_", initial_targets=number, names=("ann", "bob"))
        for number in (0, 2)
    )
    found = replay_differences(one, other)
    assert "the initial state: hunter_1: in B only" in found
    assert any(
        line.startswith("the initial state: hunter_1 (bob): x is ")
        for line in replay_differences(
            play("duel", seed=1, max_cycles=1, names=("ann", "bob")),
            play("duel", seed=2, max_cycles=1, names=("ann", "bob")),
        )
    )


def test_a_digest_alone_and_a_length_are_differences(pair):
    """The match is the same there; the shorter one is compared as far as it goes."""
    one, other = pair
    other.digests[80] = b"12345678"
    found = replay_differences(one, other)
    assert found[:2] == [
        "the states first differ in step 80",
        "step 80: all positions and scores are equal; counters, controllers' integrals or digests differ",
    ]
    for part in (other.choices, other.commands, other.digests):
        part.pop()
    assert replay_differences(one, other)[0] == "steps: 80 in A; 79 in B"


def test_states_are_compared_as_they_play_too(pair):
    """An action was edited without its digests: the order of the two files does not matter."""
    one, other = pair
    other.commands[22][1] = -one.commands[22][1]
    for first, second in ((one, other), (other, one)):
        found = replay_differences(first, second)
        assert found[1] == "the states first differ in step 23"
        assert found[2].startswith("step 23: hunter_1 (b): ")


def test_a_replay_equals_its_copy_even_if_it_does_not_play_as_recorded(pair):
    _, edited = pair
    edited.commands[22][1] = -edited.commands[22][1]
    copied = copy.deepcopy(edited)
    assert replay_differences(edited, copied) == []
    copied.title = "another"
    found = replay_differences(edited, copied)
    assert [line.partition(":")[0] for line in found] == ["title", "final scores of the hunters"]


def test_diff_exits_with_0_1_or_2(play, mixed, catch_arena):
    """Equal, different, unreadable; matches of different sizes are compared by their headers."""
    mixed.save("a.replay")
    play("duel", max_cycles=3).save("b.replay")

    equal, different, unreadable = (catch_arena("diff", "a.replay", f"{other}.replay") for other in "abc")
    assert (equal.exit_code, equal.stdout) == (0, "the replays are equal\n")
    assert different.exit_code == 1
    assert different.stdout.startswith("A: a.replay\nB: b.replay\n")
    assert "hunters: 4 in A; 2 in B" in different.stdout
    assert "with different hunters" in different.stdout
    assert (unreadable.exit_code, unreadable.stderr[:27]) == (2, "error: c.replay: cannot be ")


def test_actions_names_and_captures_of_prey_are_compared(hunted):
    other = copy.deepcopy(hunted)
    other.names = (*hunted.names[:6], "r")
    other.commands[12][hunted.config.hunters + 2] = 0.5, -0.25
    other.withdrawals.remove((90, 5))
    found = replay_differences(hunted, other)

    assert found[0] == "the agent of prey_2: 'p' in A; 'r' in B"
    assert re.match(
        r"step 13: prey_2 acts differently: linear \S+ and angular \S+ of the limits in A; "
        r"linear \+0.5 and angular -0.25 of the limits in B$",
        found[1],
    )
    assert found[-1].startswith("final catches of each prey: ")


def test_matches_with_different_prey_have_only_their_headers_compared(play):
    one, other = (play("duel", max_cycles=3, prey=prey) for prey in (1, 2))
    assert replay_differences(one, other) == [
        "prey: 1 in A; 2 in B",
        "the agent of prey_1: none in A; 'prey_1' in B",
        "with different prey, actions and states cannot be compared",
    ]
