"""Teams and prey play, forfeit, and are ranked and compared by side."""

from collections import Counter
from itertools import product

import pytest
from tournament.agents import write_agent
from tournament.runs import run
from tournament.seats import blocks_of

import catch_arena
from catch_arena import Replay, scenario
from catch_arena.policy import PreyView
from catch_arena.tournament.isolation.quotas import Quotas
from catch_arena.tournament.isolation.sandbox import Sandbox
from catch_arena.tournament.loading import create_policy
from catch_arena.tournament.match import ranks_of_sides
from catch_arena.tournament.match_loop import play_entrants, play_match
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import FORMATS, plan_of, round_robin
from catch_arena.tournament.players import enter
from catch_arena.tournament.statistics.outcomes import on_side

PAIRS = scenario("pairs", time_limit_s=8)
TAG = scenario("tag", time_limit_s=8)
HERD = scenario("herd", time_limit_s=8)

BOTH = """
class Agent:
    def reset(self, seed):
        self.seed = seed
        print("seed", seed)

    def act(self, view):
        return 1 if view.targets else 0


class Prey:
    def reset(self, seed):
        pass

    def act(self, view):
        assert len(view.hunters) == (view.limits.hunters if view.alive else 0)
        return 1.0, 0.5
"""


RESETS_AND_ACTS = "    def reset(self, seed): pass\n    def act(self, view): return 0.0, 0.0\n"


class Holds:
    def __init__(self, fails_in=None, control="target"):
        self.fails_in, self.control, self.steps = fails_in, control, 0

    def reset(self, seed):
        self.seed = seed

    def act(self, view):
        self.steps += 1
        if self.steps == self.fails_in:
            raise ValueError("it fails")
        return (0.0, 0.0) if isinstance(view, PreyView) or self.control == "velocity" else 0


@pytest.mark.rule("R11.1")
def test_r11_1_a_match_is_ranked_by_team_and_says_who_of_it_caught_what(tmp_path):
    result = play_entrants(PAIRS, 5, enter(["patrol", "idle"]), None, record=tmp_path / "m.replay")
    assert result.scores == (sum(result.catches[:2]), 0)
    assert min(result.catches[:2]) > 0
    assert result.ranks == (1, 2)
    assert result.verdicts[0]["GRANTED"] == result.scores[0]
    assert Replay.load(tmp_path / "m.replay").names == ("patrol", "patrol", "idle", "idle")


@pytest.mark.rule("R11.3")
def test_r11_3_a_match_counts_contests_of_teams_once_and_those_of_team_mates_apart(tmp_path):
    result = play_entrants(
        scenario("pairs", time_limit_s=60, reach_m=0.6), 3, enter(["nearest", "nearest"]), None, record=tmp_path / "m"
    )
    won, lost, to_mates = Counter(), Counter(), Counter()
    for contest in catch_arena.explain(Replay.load(tmp_path / "m")).contests:
        winner, *losers = [(claim.seat // 2, claim.mate) for claim in contest.claims]
        rivals = {team for team, mate in losers if not mate}
        assert winner[0] not in rivals
        won[winner[0]] += bool(rivals)
        lost.update(rivals)
        to_mates.update(team for team, mate in losers if mate)
    assert result.contests_won == (won[0], won[1])
    assert result.contests_lost == (lost[0], lost[1])
    assert result.lost_to_mates == (to_mates[0], to_mates[1])
    assert min(lost[0], lost[1], to_mates[0]) > 0, (lost, to_mates)
    assert sum(tally.get("LOST_CONTEST", 0) for tally in result.verdicts) >= lost.total() + to_mates.total()


@pytest.mark.rule("R11.1")
def test_r11_1_what_fails_in_one_seat_forfeits_all_seats_and_its_team_comes_last():
    policies = [Holds(), Holds(fails_in=3), Holds(), Holds()]
    withdrawn = []
    result = play_match(PAIRS, 5, policies, ["a", "a", "b", "b"], on_forfeit=lambda seat, _: withdrawn.append(seat))
    assert result.forfeit_codes == ("FORFEIT_CRASH", None)
    assert result.ranks == (2, 1)
    assert withdrawn == [0, 1]
    assert (policies[0].steps, policies[1].steps, policies[2].steps) == (3, 3, 80)
    assert (result.forfeits[0].seat, result.forfeits[0].step, result.thinking[0].moves) == (1, 3, 6)


def test_of_two_team_mates_that_fail_in_one_step_the_lower_seat_is_named():
    result = play_match(PAIRS, 5, [Holds(), Holds(), Holds(fails_in=2), Holds(fails_in=2)], list("aabb"))
    assert result.forfeits[1].seat == 2


@pytest.mark.rule("R12.5")
def test_r12_5_prey_is_ranked_among_prey_and_who_failed_behind_all_other():
    assert ranks_of_sides((3, 1, 3, 0), (None,) * 4, 0) == (3, 2, 3, 1)
    assert ranks_of_sides((3, 0, 9, 2), (None, 5, None, 7), 0) == (1, 3, 2, 4)
    hunters = [Holds(control="velocity") for _ in range(4)]
    prey = [Holds(fails_in=1 if number == 1 else None, control="velocity") for number in range(4)]
    result = play_match(HERD, 1, [*hunters, *prey], list("abcdefgh"))
    assert result.forfeit_codes == (None,) * 5 + ("FORFEIT_CRASH", None, None)
    assert result.ranks[5] == 4
    assert result.catches == ()


@pytest.mark.rule("R12.7")
def test_r12_7_who_has_no_prey_of_its_own_plays_the_shipped_one(tmp_path):
    (tmp_path / "mine.py").write_text(BOTH)
    mine, nearest, flee = enter([str(tmp_path / "mine.py"), "nearest", "flee"])
    assert (mine.prey, nearest.prey, flee.prey) == (True, False, True)
    assert nearest.on("prey").spec == flee.on("prey").spec
    kinds = [type(create_policy(one.spec, one.side)) for one in (mine.on("prey"), mine)]
    assert [kind.__name__ for kind in kinds] == ["Prey", "Agent"]
    assert kinds[0].__module__ == kinds[1].__module__
    hunters = enter(["intercept", "patrol", "nearest"])
    ends = [
        play_entrants(TAG, 3, [*hunters, prey], None, record=tmp_path / f"{prey.name}.replay").digest
        for prey in (mine, nearest, flee)
    ]
    assert ends[1] == ends[2] != ends[0]
    named = [Replay.load(tmp_path / f"{prey.name}.replay").names[3] for prey in (mine, nearest, flee)]
    assert named == ["mine", "nearest (plays flee)", "flee"]
    assert [prey.on("prey").digest for prey in (mine, nearest, flee)] == [mine.digest, flee.digest, flee.digest]


@pytest.mark.rule("R12.7")
@pytest.mark.parametrize("config", [PAIRS, TAG], ids=["pairs", "tag"])
def test_r12_7_isolated_agents_play_the_same_match(tmp_path, config):
    """Team-mates in processes of their own, and prey with the view of prey."""
    (tmp_path / "mine.py").write_text(BOTH)
    mine = str(tmp_path / "mine.py")
    specs = ["nearest", "patrol", mine, mine] if config is TAG else [mine, "nearest"]
    seeds = (1, 2, 3, 4)[: len(specs)]
    with Sandbox(Quotas()) as sandbox:
        isolated = play_entrants(config, 3, enter(specs, sandbox), sandbox, agent_seeds=seeds)
    trusted = play_entrants(config, 3, enter(specs), None, agent_seeds=seeds)
    assert not any(isolated.forfeit_codes), isolated.forfeits
    assert isolated == trusted
    if config is PAIRS:  # each instance has a seed of its own
        printed = [line for line in isolated.logs[0].splitlines() if line.startswith("seed")]
        assert printed[0] == "seed 1"
        assert len(set(printed)) == 2


@pytest.mark.parametrize(
    ("prey", "message"),
    [
        ("class Prey:\n    def reset(self, seed): pass\n", "Prey must have a method act"),
        ("Prey = 3\n", "has no class Prey"),
        (
            'class Prey:\n    control = "target"\n' + RESETS_AND_ACTS,
            "Prey.control must be velocity or be left out (R12.2)",
        ),
        (
            'import numpy\nclass Prey:\n    control = numpy.array(["target", "velocity"])\n' + RESETS_AND_ACTS,
            "Prey.control must be velocity or be left out (R12.2)",
        ),
    ],
)
def test_prey_that_cannot_play_forfeits_as_prey_alone(tmp_path, prey, message):
    mine = write_agent(tmp_path / "mine.py", before=prey)
    others = ["nearest", "patrol", "intercept"]
    assert play_entrants(TAG, 1, enter([mine, *others]), None).forfeit_codes == (None,) * 4
    result = play_entrants(TAG, 1, enter([*others, mine]), None)
    assert result.forfeit_codes[3] == "FORFEIT_INIT"
    assert message in result.forfeits[3].reason


def test_prey_may_name_no_control(tmp_path):
    mine = write_agent(tmp_path / "mine.py", before="class Prey:\n    control = None\n" + RESETS_AND_ACTS)
    assert play_entrants(TAG, 1, enter(["nearest", "patrol", "intercept", mine]), None).forfeit_codes == (None,) * 4


def test_every_format_seats_each_player_of_a_block_equally_often_on_each_place():
    for config in (TAG, HERD, scenario("tag", teams=((0, 1, 2),))):
        parties = Parties.of(config)
        entrants = parties.group + 2
        for form, most in product(FORMATS, (1, 20_000)):
            plan = plan_of(form, entrants, parties, 1, 7, most)
            matches = list(plan)
            assert len(matches) == plan.size
            assert [match.id for match in matches] == sorted(match.id for match in matches)
            for block in blocks_of(matches):
                assert len(block) == parties.block_size
                for party in range(len(parties)):
                    assert len(set(Counter(match.seating[party] for match in block).values())) == 1
                assert all(len(set(match.seating)) == len(parties) for match in block)
                assert len({match.seating for match in block}) == len(block)


@pytest.mark.parametrize("teams", [None, ((0, 1, 2),)])
def test_a_prey_that_is_alone_is_compared_with_one_that_met_the_same_hunters(teams):
    config = scenario("tag", time_limit_s=3, teams=teams)
    parties = Parties.of(config)
    entrants = enter(["intercept", "patrol", "nearest", "corners", "random"][: parties.group])
    played = run(config, entrants, round_robin(len(entrants), parties, 1, 3))
    assert len(played) == parties.block_size
    caught = {one.match.seating: one.result.scores[-1] for one in played}
    hunters = list(dict.fromkeys(one.match.seating[:-1] for one in played))
    joined = on_side(played, parties, "prey")
    assert len(joined) == len(hunters)
    for one, group in zip(joined, hunters, strict=True):
        expected = [caught[(*group, prey)] for prey in one.seating]
        assert list(one.scores) == expected
        assert (expected[0] < expected[1]) == (one.ranks[0] < one.ranks[1])
