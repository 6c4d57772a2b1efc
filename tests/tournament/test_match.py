"""A match ranks agents, gives them their seeds, and goes on when one of them fails."""

import numpy as np
import pytest
from tournament.played_matches import made_up

from catch_arena import Replay, interrupts, scenario
from catch_arena.errors import AgentError, ConfigError
from catch_arena.tournament.loading import create_policy
from catch_arena.tournament.match import Forfeit, MoveTimes, ranks_of
from catch_arena.tournament.match_loop import play_match
from catch_arena.tournament.players import enter

SHORT = scenario("duel", time_limit_s=10)


class Plays:
    """Holds for four steps, then answers by a function of its view."""

    def __init__(self, answer=lambda _: 0):
        self.answer, self.step = answer, 0

    def reset(self, seed):
        self.seed = seed

    def act(self, view):
        self.step += 1
        return self.answer(view) if self.step >= 5 else 0


def test_equal_scores_share_a_rank_and_who_forfeits_ranks_behind_by_how_long_it_lasted():
    assert ranks_of((5, 5, 3)) == (1, 1, 3)
    assert ranks_of((1, 4, 2, 4)) == (4, 1, 3, 1)
    assert ranks_of((9, 0, 5, 7, 1), (3, None, 8, 3, None)) == (4, 2, 3, 4, 1)


def test_times_of_moves_are_added_up_and_without_moves_there_is_no_mean():
    times = MoveTimes.of_all([MoveTimes(1, 0.25, 0.25), MoveTimes(3, 0.75, 0.5)])
    assert (times, times.mean_ms) == (MoveTimes(4, 1.0, 0.5), 250.0)
    assert MoveTimes.of_all([]) == MoveTimes(0, 0.0, 0.0)
    assert np.isnan(MoveTimes.of_all([]).mean_ms)


def test_the_same_seed_plays_the_same_match_and_another_one_does_not():
    def digest(seed):
        return play_match(
            SHORT, seed, [create_policy(one.spec) for one in enter(["nearest", "random"])], ["a", "b"]
        ).digest

    assert digest(1) == digest(1) != digest(2)


@pytest.mark.parametrize(
    ("planned", "seeds"), [((5, 2**63 - 1), [5, 2**63 - 1]), ((), [6258151732429448147, 2098520664363859099])]
)
def test_agents_seeds_are_those_of_the_plan_or_follow_from_the_match_and_the_seat(planned, seeds):
    """These numbers never change, or a match could not be played again."""
    agents = [Plays(), Plays()]
    play_match(SHORT, 77, agents, ["a", "b"], agent_seeds=planned)
    assert [agent.seed for agent in agents] == seeds


def test_a_control_that_is_an_array_is_refused_in_one_line():
    agent = Plays()
    agent.control = np.zeros(2)
    with pytest.raises(AgentError, match=r"^control of .* must be target, velocity or full, got array\(\[0., 0.\]\)$"):
        play_match(SHORT, 1, [agent, Plays()], ["a", "b"])


def test_scores_agree_with_the_verdicts_and_with_the_replay(tmp_path):
    names = ["nearest", "contested"]
    result = play_match(
        SHORT, 3, [create_policy(one.spec) for one in enter(names)], names, title="a test", record=tmp_path / "m.replay"
    )
    assert result.scores == tuple(verdicts["GRANTED"] for verdicts in result.verdicts)
    replay = Replay.load(tmp_path / "m.replay")
    assert (replay.names, replay.title, replay.seed, replay.steps) == (("nearest", "contested"), "a test", 3, 100)
    *_, last = replay.worlds()
    assert tuple(hunter.score for hunter in last.hunters) == result.scores
    assert replay.digests[-1].hex() == result.digest


def test_one_that_cannot_begin_forfeits_before_the_first_step():
    class Fails(Plays):
        def reset(self, seed):
            raise SystemExit(seed)

    result = play_match(SHORT, 0, [Fails(), Plays()], ["bad", "good"])
    assert result.forfeit_codes == ("FORFEIT_INIT", None)
    assert (result.forfeits[0].step, result.forfeits[0].observation, result.thinking[0].moves) == (0, None, 0)


def test_what_an_agent_does_to_its_view_changes_nothing():
    def vandal(view):
        view.observation[:] = [0.0] * len(view.observation)
        view.mask[0] = 0
        return 0

    (nearest,) = enter(["nearest"])
    one, other = (
        play_match(SHORT, 5, [policy, create_policy(nearest.spec)], ["a", "b"]).digest
        for policy in (Plays(vandal), Plays())
    )
    assert one == other


def test_a_match_needs_a_policy_for_each_seat():
    with pytest.raises(ConfigError, match="players must be 2"):
        play_match(SHORT, 0, [Plays()], ["a"])


def test_parties_of_one_side_share_a_win():
    """Two of three hunters, and one of two prey."""
    result = made_up(0, (0, 1, 2, 3, 4), (), ranks=(1, 1, 3, 1, 2)).result
    shares = [result.win_share(party, slice(3) if party < 3 else slice(3, None)) for party in range(5)]
    assert shares == [0.5, 0.5, 0.0, 1.0, 0.0]


def test_a_party_that_forfeited_does_not_win_even_if_all_others_forfeited_too():
    late, early = Forfeit("FORFEIT_CRASH", 9, ""), Forfeit("FORFEIT_CRASH", 3, "")
    result = made_up(0, (0, 1), (0, 0), ranks=(1, 2), forfeits=(late, early)).result
    assert [result.win_share(party, slice(2)) for party in range(2)] == [0.0, 0.0]


def test_an_interrupt_that_an_agent_has_caught_ends_the_match_after_the_step(monkeypatch):
    class Swallows:
        def reset(self, seed):
            pass

        def act(self, _):
            monkeypatch.setattr(interrupts._Command, "first_signal", 2)
            return 0

    with pytest.raises(KeyboardInterrupt):
        play_match(scenario("duel"), 1, [Swallows(), Swallows()], ["a", "b"])
