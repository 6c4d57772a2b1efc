"""Seats, names, labels, lots and the order of requests are fair, as docs/explanation/ratings.md says."""

from dataclasses import replace
from itertools import cycle, islice
from random import Random

import numpy as np
import pytest
from scipy import special
from tournament.runs import run
from tournament.seats import hunters, listed

from catch_arena import scenario
from catch_arena.arbitration import arbitrate
from catch_arena.envs.parallel import CatchArenaEnv
from catch_arena.tournament.loading import create_policy
from catch_arena.tournament.match_loop import play_match
from catch_arena.tournament.parties import Parties
from catch_arena.tournament.plans.schedule import round_robin
from catch_arena.tournament.players import enter
from catch_arena.tournament.statistics.outcomes import SideResults
from catch_arena.tournament.statistics.ratings import rate
from catch_arena.tournament.statistics.separation import holm, p_values
from catch_arena.verdicts import Verdict

LEVEL = 0.01
"""A fair arena fails as often: all that depends on chance together, corrected for their number."""
OTHERS = ("nearest", "contested", "patrol", "first")
"""The agents that play with the twins."""
TARGETS = ("one", "two")
each_scenario = pytest.mark.parametrize("name", ["standard", "pairs", "tag"])


def p_of_no_bias(rows):
    """Return how often independent rows with a mean of 0 have a mean at least so far from it (a score test)."""
    moments, mean = rows.T @ rows / len(rows), rows.mean(axis=0)
    rank = int(np.linalg.matrix_rank(moments, hermitian=True))
    distance = len(rows) * float(mean @ np.linalg.pinv(moments, hermitian=True) @ mean)
    return float(special.chdtrc(rank, distance)) if rank else 1.0


def seats_differ(identical):
    """Return the p-values of the wins and of the scores of identical agents, by seat."""
    return [
        p_of_no_bias(values - values.mean(axis=1, keepdims=True)) for values in (identical.win_shares, identical.scores)
    ]


def outcomes_by_side(config, entrants, plan):
    played, parties = run(config, entrants, plan, jobs=2), Parties.of(config)
    assert not any(code for one in played for code in one.result.forfeit_codes)
    return {side: SideResults.of(entrants, played, parties, side).outcomes for side in parties.sides}


def drawn_step(config, random):
    """Return the requests of one step on a few points, so that they often meet, and often from equal distances."""
    points = [(x * config.reach_m / 3, y * config.reach_m / 3) for x in range(4) for y in range(4)]
    return {
        "hunters": random.choices(points, k=config.hunters),
        "targets": dict(zip(TARGETS, random.choices(points, k=2), strict=True)),
        "requests": [(seat, random.choice([*TARGETS, "nobody"])) for seat in range(config.hunters)],
        "reach_m": config.reach_m,
        "seed": random.getrandbits(48),
    }


def lots_in(step):
    """Yield each target that a lot decides on (R5.5), the seats that are tied for it, and the seat that wins it."""
    for target in TARGETS:
        rulings = [ruling for ruling in arbitrate(**step) if ruling.target == target]
        contenders = [one for one in rulings if one.verdict in {Verdict.GRANTED, Verdict.LOST_CONTEST}]
        nearest = min((one.distance_um for one in contenders), default=None)
        tied = [one for one in contenders if one.distance_um == nearest]
        if len(tied) > 1:
            (winner,) = (one.hunter for one in tied if one.verdict is Verdict.GRANTED)
            yield target, [one.hunter for one in tied], winner


@pytest.mark.nightly
@each_scenario
def test_no_seat_has_an_advantage_and_one_agent_under_two_names_has_one_rating(name):
    """2000 matches of identical agents on targets of their own, 500 of twins, and the lots of 2000 steps."""
    config = scenario(name)
    parties = Parties.of(config)
    seats = list(round_robin(len(parties), hunters(len(parties)), 2000, 1))[:: len(parties)]
    in_order = listed([replace(match, seating=tuple(range(len(parties)))) for match in seats])
    doubts = {}
    for side, found in outcomes_by_side(config, enter(["nearest"] * len(parties)), in_order).items():
        if len(parties.seats[parties.on(side)]) > 1:  # one prey alone has no other to differ from
            doubts[side, "wins"], doubts[side, "scores"] = seats_differ(found)
    twins = enter(["nearest", "nearest", *islice(cycle(OTHERS), parties.group - 2)])
    plan = round_robin(len(twins), parties, 500 // parties.block_size, 2)
    for side, found in outcomes_by_side(config, twins, plan).items():
        doubts[side, "twins"] = p_values(rate(found))[0, 1]
    random = Random(3)
    drawn = [
        [(seat in tied) * ((seat == winner) - 1 / len(tied)) for seat in range(config.hunters)]
        for _ in range(2000)
        for _, tied, winner in lots_in(drawn_step(config, random))
    ]
    doubts["lots"] = p_of_no_bias(np.array(drawn))
    corrected = holm(np.array([*doubts.values()]))
    assert not {question: p for question, p in zip(doubts, corrected, strict=True) if p < LEVEL}


@each_scenario
def test_the_order_of_a_steps_actions_does_not_matter(name):
    config, random = scenario(name, control="target"), Random(5)
    one, other = CatchArenaEnv(config), CatchArenaEnv(config)
    for env in (one, other):
        env.reset(seed=5)
    while one.agents:
        drives = (random.random(), random.uniform(-1.0, 1.0))
        actions = {agent: drives if "prey" in agent else 1 for agent in one.agents}
        one.step(actions)
        other.step({agent: actions[agent] for agent in random.sample(sorted(actions), len(actions))})
    assert one.digest() == other.digest()


@each_scenario
def test_agents_names_and_places_among_the_entrants_do_not_matter(name):
    """`nearest` draws nothing from the seed that it is told."""
    config = scenario(name)
    (agent,) = enter(["nearest"])
    kinds = [agent] * config.hunters + [agent.on("prey")] * config.prey
    indices = list(range(len(kinds)))
    digests = {
        play_match(
            config,
            6,
            [create_policy(kind.spec, kind.side) for kind in kinds],
            list(map(str, turned)),
            agent_seeds=turned,
        ).digest
        for turned in (indices, indices[1:] + indices[:1], indices[::-1])
    }
    assert len(digests) == 1
