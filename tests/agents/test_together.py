"""The agent for catches that need several hunters goes where its team-mates go, and waits there."""

import pytest

from catch_arena import Limits, VectorArena, View, scenario
from catch_arena.agents.nearest import Agent as Nearest
from catch_arena.agents.together import Agent, decide
from catch_arena.layout import observation_size
from catch_arena.tournament.match_loop import play_match

WEST = 3.141592653589793


def commands(hunters, targets, name="partners", **settings):
    """Return the commands of all hunters that stand at these poses."""
    config = scenario(name, control="velocity", **settings)
    arena = VectorArena(config, 1)
    arena.reset(seed=1)
    observations, _ = arena.place([[(*pose, 0.0) for pose in hunters]], [[(*at, 0.0, 0.0, 0.0) for at in targets]])
    columns = observation_size(config)
    return [
        decide(View(observations[0, seat, :columns].tolist(), (), Limits.of(config, seat)))
        for seat in range(config.hunters)
    ]


RIVALS = [(9.0, 9.0, 0.0), (10.0, 9.0, 0.0)]


@pytest.mark.parametrize("needed", [1, 2])
def test_two_mates_go_to_the_target_at_which_the_later_of_them_is_soonest(needed):
    """The target lies between the two hunters, and a nearer one is behind each of them."""
    hunters = [(2.0, 2.0, 0.0), (6.0, 2.0, WEST), *RIVALS]
    targets = [(1.5, 2.0), (4.0, 2.0), (6.5, 2.0)]
    for speed, turn in commands(hunters, targets, hunters_per_catch=needed)[:2]:
        assert (speed, abs(turn) < 0.01) == ((1.0, True) if needed == 2 else (0.0, False))


def test_it_waits_for_a_mate_that_comes_later():
    """The nearer hunter stops at the target; its mate drives at full speed."""
    first, second, *_ = commands([(2.0, 2.0, 0.0), (6.0, 2.0, WEST), *RIVALS], [(2.1, 2.0)])
    assert first == pytest.approx((0.1, 0.0), abs=1e-4)
    assert second == pytest.approx((1.0, 0.0), abs=1e-4)


def test_two_of_three_mates_are_enough():
    """The third, far away, does not keep the others from the target that is near to them."""
    hunters = [(2.0, 2.0, 0.0), (4.0, 2.0, WEST), (10.0, 10.0, WEST), *RIVALS[:1]]
    targets = [(3.0, 2.0), (9.5, 10.0)]
    one, other, third, _ = commands(hunters, targets, teams=((0, 1, 2), (3,)))
    assert [one, other] == [pytest.approx((1.0, 0.0), abs=1e-4)] * 2
    assert third == pytest.approx((0.5, 0.0), abs=1e-4), "it comes to rest at its own"
    settings = {"teams": ((0, 1, 2), (3,)), "hunters_per_catch": 3}
    speed, turn = commands(hunters, targets, **settings)[2]
    assert (speed, turn) != third, "the others would come later to it than it comes to them"


def test_without_a_mate_in_view_it_goes_to_the_soonest_target_and_waits():
    alone = commands([(2.0, 2.0, 0.0), (9.0, 2.0, WEST), *RIVALS], [(2.1, 2.0), (4.0, 2.0)], view_radius_m=3.0)[0]
    assert alone == pytest.approx((0.1, 0.0), abs=1e-4)


def test_a_team_of_it_beats_a_team_that_does_not_wait():
    players = [Agent(), Agent(), Nearest(), Nearest()]
    ours, theirs = play_match(scenario("partners"), 3, players, ["together"] * 2 + ["nearest"] * 2).scores
    assert ours > 30 > theirs
